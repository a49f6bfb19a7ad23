// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "firmware/core/expected.h"
#include "protocol/dji/catalogue.h"
#include "protocol/dji/value.h"

namespace m100::protocol {

// Codes of commands in general; kAckSuccess does not hold where a namespace below gives 0 another meaning.
inline constexpr std::uint16_t kAckSuccess = 0x0000;
inline constexpr std::uint16_t kAckKeyError = 0xFF00;
inline constexpr std::uint16_t kAckNotAuthorised = 0xFF01;
inline constexpr std::uint16_t kAckInsufficientRights = 0xFF02;

namespace activation_ack {
inline constexpr std::uint16_t kActivated = 0;
inline constexpr std::uint16_t kParameterError = 1;
inline constexpr std::uint16_t kEncryptionNotUnderstood = 2;
inline constexpr std::uint16_t kNewDevice = 3;
inline constexpr std::uint16_t kNoMobileApp = 4;
inline constexpr std::uint16_t kNoInternet = 5;
inline constexpr std::uint16_t kServerRefused = 6;
inline constexpr std::uint16_t kLevelInsufficient = 7;
inline constexpr std::uint16_t kVersionMismatch = 8;
}  // namespace activation_ack

namespace control_ack {
inline constexpr std::uint16_t kNotInModeF = 0x0000;
inline constexpr std::uint16_t kReleased = 0x0001;
inline constexpr std::uint16_t kObtained = 0x0002;
inline constexpr std::uint16_t kObtaining = 0x0003;
inline constexpr std::uint16_t kReleasing = 0x0004;
inline constexpr std::uint16_t kIocActive = 0x00C9;
}  // namespace control_ack

namespace motor_ack {
inline constexpr std::uint16_t kDone = 0;
inline constexpr std::uint16_t kNeedsControl = 1;
inline constexpr std::uint16_t kAlready = 2;
inline constexpr std::uint16_t kInAir = 3;
}  // namespace motor_ack

namespace task_ack {
inline constexpr std::uint16_t kRefused = 1;
inline constexpr std::uint16_t kStarted = 2;
}  // namespace task_ack

namespace task_query_ack {
inline constexpr std::uint16_t kWrongNumber = 1;
inline constexpr std::uint16_t kInProgress = 3;
inline constexpr std::uint16_t kFailed = 4;
inline constexpr std::uint16_t kSucceeded = 5;
}  // namespace task_query_ack

enum class AckVerdict : std::uint8_t {
  kDone,       ///< the command has been executed
  kSendAgain,  ///< the protocol requires the same request once more
  kRetry,      ///< a person or another device must act first; then repeat the request
  kRefused,    ///< a repetition will not help
};

/// The meaning of an answer, and the remedy as a sentence for the operator.
struct AckMeaning {
  std::uint16_t code = 0;
  std::string_view name;
  AckVerdict verdict = AckVerdict::kRefused;
  std::string_view remedy;
};

/// @returns the meaning of a code as the answer to this command; an unknown code has the name "unknown_code".
AckMeaning ack_meaning(MessageId command, std::uint16_t code);

/// Writes the two bytes that every answer in sets 0x00 and 0x01 (except VersionAnswer) must have, no more and no fewer:
/// with one byte DJI's SDK invents the other, with three it throws, with none it crashes.
Value encode_ack(std::uint16_t code);

/// @returns kInvalidArgument: not exactly two bytes.
core::Expected<std::uint16_t> decode_ack(std::span<const std::byte> value);

/// The answer to a version query: firmware 3.1 sends 49 bytes, firmware 2.3 leaves out the device id (38 bytes).
struct VersionAnswer {
  static constexpr std::size_t kBytes = 49;
  static constexpr std::size_t kOldBytes = 38;
  std::uint16_t code = 0;            ///< 0 activated, 0xFF01 not activated
  std::uint32_t version_crc = 0;     ///< of the version text; must have no zero byte, or SDK 3.2.1 misreads the answer
  std::array<char, 11> device_id{};  ///< ten characters and a zero; empty if firmware 2.3 answered
  std::array<char, 32> version_name{};  ///< e.g. "SDK-v1.0 BETA M100-03.01.01.00", zero padded
  bool activated() const { return code == kAckSuccess; }
};

Value encode(const VersionAnswer& answer);
/// @returns kInvalidArgument: neither 49 nor 38 bytes.
core::Expected<VersionAnswer> decode_version_answer(std::span<const std::byte> value);

/// The number to activate with, 0xAABBCCDD for A.B.C.D, from the text "... M100-03.01.01.00". On an M100 from firmware
/// 3 on the third number of the text counts tens: 03.01.01.00 is version 3.1.10.0 = 0x03010A00.
/// @returns kInvalidArgument: the text has another form, or a number above 255.
core::Expected<std::uint32_t> sdk_version(const VersionAnswer& answer);

/// The text in the array, up to the first zero.
template <std::size_t kSize>
std::string_view text(const std::array<char, kSize>& characters) {
  const std::string_view all(characters.data(), kSize);
  return all.substr(0, all.find('\0'));
}

}  // namespace m100::protocol
