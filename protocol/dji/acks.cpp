// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/dji/acks.h"

#include <array>

#include "protocol/bytes.h"

namespace m100::protocol {
namespace {

struct Row {
  MessageId command;
  AckMeaning meaning;
};

constexpr auto kDone = AckVerdict::kDone;
constexpr auto kAgain = AckVerdict::kSendAgain;
constexpr auto kRetry = AckVerdict::kRetry;
constexpr auto kRefused = AckVerdict::kRefused;

// std::to_array: GCC 12 puts a constant whose std::array type it deduces into RAM.
constexpr auto kCommon = std::to_array<AckMeaning>({
    AckMeaning{kAckKeyError, "key_error", kRefused, "the autopilot cannot decrypt: check the key, activate again"},
    AckMeaning{kAckNotAuthorised, "not_authorised", kRefused, "activate first, then obtain control"},
    AckMeaning{kAckInsufficientRights, "insufficient_rights", kRefused, "the app id lacks the rights for this"},
});

constexpr auto kRows = std::to_array<Row>({
    Row{ids::kVersionQuery, {kAckSuccess, "activated", kDone, ""}},
    Row{ids::kVersionQuery, {kAckNotAuthorised, "not_activated", kDone, "activate next"}},

    Row{ids::kActivation, {activation_ack::kActivated, "activated", kDone, ""}},
    Row{ids::kActivation, {activation_ack::kParameterError, "parameter_error", kRefused, "check app id and api level"}},
    Row{ids::kActivation,
        {activation_ack::kEncryptionNotUnderstood, "encryption_not_understood", kRefused, "send activation plain"}},
    Row{ids::kActivation,
        {activation_ack::kNewDevice, "new_device", kRetry,
         "connect the mobile app with internet to the remote controller once, then repeat"}},
    Row{ids::kActivation,
        {activation_ack::kNoMobileApp, "mobile_app_not_connected", kRetry,
         "connect the mobile app to the remote controller, then repeat"}},
    Row{ids::kActivation,
        {activation_ack::kNoInternet, "mobile_app_without_internet", kRetry,
         "give the mobile device internet, then repeat"}},
    Row{ids::kActivation,
        {activation_ack::kServerRefused, "server_refused", kRefused, "check app id and key at DJI's developer site"}},
    Row{ids::kActivation,
        {activation_ack::kLevelInsufficient, "level_insufficient", kRefused, "the app id is for a lower API level"}},
    Row{ids::kActivation,
        {activation_ack::kVersionMismatch, "version_mismatch", kRetry,
         "query the version and activate with the number it reports"}},

    Row{ids::kTelemetryFrequency, {kAckSuccess, "set", kDone, ""}},
    Row{ids::kTelemetryFrequency, {0x0001, "parameter_error", kRefused, "use the codes 0 to 5"}},

    Row{ids::kToMobile, {kAckSuccess, "sent", kDone, ""}},

    Row{ids::kControlRequest,
        {control_ack::kNotInModeF, "not_in_F_mode", kRetry, "turn the mode switch of the remote controller to F"}},
    Row{ids::kControlRequest, {control_ack::kReleased, "release_ok", kDone, ""}},
    Row{ids::kControlRequest, {control_ack::kObtained, "obtain_ok", kDone, ""}},
    Row{ids::kControlRequest,
        {control_ack::kObtaining, "obtain_pending_resend", kAgain,
         "ask once more; if this never ends, the mobile app holds control: close it"}},
    Row{ids::kControlRequest, {control_ack::kReleasing, "release_pending_resend", kAgain, "ask once more"}},
    Row{ids::kControlRequest,
        {control_ack::kIocActive, "ioc_active", kRetry, "leave IOC (course lock, home lock) in the mobile app"}},

    Row{ids::kMotors, {motor_ack::kDone, "done", kDone, ""}},
    Row{ids::kMotors, {motor_ack::kNeedsControl, "needs_control", kRefused, "obtain control first"}},
    Row{ids::kMotors, {motor_ack::kAlready, "already_in_that_state", kDone, ""}},
    Row{ids::kMotors, {motor_ack::kInAir, "refused_in_the_air", kRefused, "land first"}},

    Row{ids::kTask,
        {task_ack::kRefused, "refused", kRefused,
         "a take-off needs stopped motors, a landing an aircraft in the air, both need control"}},
    Row{ids::kTask, {task_ack::kStarted, "started", kDone, ""}},

    Row{ids::kTaskQuery, {task_query_ack::kWrongNumber, "wrong_number", kRefused, "ask with the number of the task"}},
    Row{ids::kTaskQuery, {task_query_ack::kInProgress, "in_progress", kDone, ""}},
    Row{ids::kTaskQuery, {task_query_ack::kFailed, "failed", kDone, ""}},
    Row{ids::kTaskQuery, {task_query_ack::kSucceeded, "succeeded", kDone, ""}},

    Row{ids::kControlLost, {kAckSuccess, "noted", kDone, ""}},
});

/// Takes up to three digits from the front of text. @returns -1 without a digit or above 255.
int take_number(std::string_view& text) {
  int number = 0;
  std::size_t digits = 0;
  while (digits < 3 && digits < text.size() && text[digits] >= '0' && text[digits] <= '9') {
    number = 10 * number + (text[digits] - '0');
    ++digits;
  }
  text.remove_prefix(digits);
  return digits == 0 || number > 255 ? -1 : number;
}

/// Reads four numbers A.B.C.D. @returns false if the text has another form or a number above 255.
bool take_numbers(std::string_view text, std::array<int, 4>& numbers) {
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (i > 0) {
      if (text.empty() || text.front() != '.') {
        return false;
      }
      text.remove_prefix(1);
    }
    numbers[i] = take_number(text);
    if (numbers[i] < 0) {
      return false;
    }
  }
  return text.empty();
}

}  // namespace

AckMeaning ack_meaning(MessageId command, std::uint16_t code) {
  for (const Row& row : kRows) {
    if (row.command == command && row.meaning.code == code) {
      return row.meaning;
    }
  }
  for (const AckMeaning& meaning : kCommon) {
    if (meaning.code == code) {
      return meaning;
    }
  }
  return {code, "unknown_code", AckVerdict::kRefused, "not in DJI's documents: note the code and the firmware version"};
}

Value encode_ack(std::uint16_t code) {
  return Value::of([code](ByteWriter& writer) { writer.put(code); });
}

core::Expected<std::uint16_t> decode_ack(std::span<const std::byte> value) {
  if (value.size() != sizeof(std::uint16_t)) {
    return core::Status::kInvalidArgument;
  }
  return load<std::uint16_t>(value.data());
}

Value encode(const VersionAnswer& answer) {
  return Value::of([&](ByteWriter& writer) {
    writer.put(answer.code);
    writer.put(answer.version_crc);
    writer.put(answer.device_id);
    writer.put(answer.version_name);
  });
}

core::Expected<VersionAnswer> decode_version_answer(std::span<const std::byte> value) {
  if (value.size() != VersionAnswer::kBytes && value.size() != VersionAnswer::kOldBytes) {
    return core::Status::kInvalidArgument;
  }
  ByteReader reader(value);
  VersionAnswer answer;
  answer.code = reader.take<std::uint16_t>();
  answer.version_crc = reader.take<std::uint32_t>();
  if (value.size() == VersionAnswer::kBytes) {
    reader.take(answer.device_id);
  }
  reader.take(answer.version_name);
  return answer;
}

core::Expected<std::uint32_t> sdk_version(const VersionAnswer& answer) {
  const std::string_view name = text(answer.version_name);
  const std::size_t dash = name.rfind('-');
  if (dash == std::string_view::npos) {
    return core::Status::kInvalidArgument;
  }
  std::array<int, 4> numbers{};
  if (!take_numbers({name.begin() + dash + 1, name.end()}, numbers)) {
    return core::Status::kInvalidArgument;
  }
  const std::string_view before(name.begin(), name.begin() + dash);
  const bool is_m100 = before.ends_with("M100");
  if (is_m100) {
    // Firmware 2.3 writes the third number in full (02.03.10.00).
    numbers[2] = numbers[0] >= 3 ? numbers[2] * 10 : numbers[2];
  }
  if (numbers[2] > 255) {
    return core::Status::kInvalidArgument;
  }
  std::uint32_t version = 0;
  for (const int number : numbers) {
    version = (version << 8U) | static_cast<std::uint32_t>(number);
  }
  return version;
}

}  // namespace m100::protocol
