// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/frames/message_json.h"

#include "host_tests/lab/frames/hex.h"
#include "host_tests/lab/frames/telemetry_json.h"
#include "protocol/dji/acks.h"
#include "protocol/dji/command_decoder.h"
#include "protocol/dji/commands.h"
#include "protocol/dji/pushes.h"
#include "protocol/dji/telemetry.h"

namespace m100::lab {
namespace {

using protocol::MessageId;
namespace ids = protocol::ids;

template <std::size_t kSize>
std::string text_of(const std::array<char, kSize>& characters) {
  return std::string(protocol::text(characters));
}

std::string version_text(std::uint32_t version) {
  return std::to_string(version >> 24U) + "." + std::to_string((version >> 16U) & 255U) + "." +
         std::to_string((version >> 8U) & 255U) + "." + std::to_string(version & 255U);
}

/// The frequency [Hz] of a code; 5 keeps the present one; null: no such code. 6 and 7 exist only on newer controllers.
Json hertz(int code) {
  constexpr std::array kHertz{0, 1, 10, 50, 100, -1, 200, 400};
  if (code == 5) {
    return "hold";
  }
  return code < 8 ? Json(kHertz[static_cast<std::size_t>(code)]) : Json(nullptr);
}

Json frequency_fields(std::span<const std::byte> value) {
  Json codes = Json::array();
  Json rates = Json::array();
  for (const std::byte byte : value) {  // as on the wire, not clamped as by decode_command()
    codes.push_back(std::to_integer<int>(byte));
    rates.push_back(hertz(std::to_integer<int>(byte)));
  }
  return {{"codes", codes}, {"hz", rates}};
}

Json movement_fields(const protocol::Movement& movement) {
  constexpr std::array kHorizontal{"angle", "velocity", "position", "reserved"};
  constexpr std::array kVertical{"velocity", "position", "thrust", "reserved"};
  constexpr std::array kFrames{"ground", "body", "reserved", "reserved"};
  constexpr std::array kHorizontalUnits{"deg", "m/s", "m offset", ""};
  constexpr std::array kVerticalUnits{"m/s up", "m height", "percent", ""};
  const std::size_t horizontal = movement.flag >> 6U;
  const std::size_t vertical = (movement.flag >> 4U) & 3U;
  const bool yaw_rate = (movement.flag & 8U) != 0;
  return {{"flag", movement.flag},
          {"horizontal_mode", kHorizontal[horizontal]},
          {"vertical_mode", kVertical[vertical]},
          {"yaw_mode", yaw_rate ? "rate" : "angle"},
          {"horizontal_frame", kFrames[(movement.flag >> 1U) & 3U]},
          {"stable", movement.flag & 1U},
          {"x", movement.x},
          {"y", movement.y},
          {"z", movement.z},
          {"yaw", movement.yaw},
          {"units",
           {{"x", kHorizontalUnits[horizontal]},
            {"y", kHorizontalUnits[horizontal]},
            {"z", kVerticalUnits[vertical]},
            {"yaw", yaw_rate ? "deg/s" : "deg"}}}};
}

Json channel_fields(const protocol::VirtualRcData& data) {
  namespace channel = protocol::vrc_channel;
  return {{"channels", data.channels},
          {"roll", data.channels[channel::kRoll]},
          {"pitch", data.channels[channel::kPitch]},
          {"throttle", data.channels[channel::kThrottle]},
          {"yaw", data.channels[channel::kYaw]},
          {"gear", data.channels[channel::kGear]},
          {"mode", data.channels[channel::kMode]}};
}

/// Name and fields of each command; the frequency command is described from its raw bytes.
struct CommandDescriber {
  std::span<const std::byte> value;

  Description operator()(std::monostate) const { return {"unknown"}; }
  Description operator()(const protocol::VersionQuery& query) const {
    return {"version_query", {{"arbitrary", query.arbitrary}}};
  }
  Description operator()(const protocol::Activation& activation) const {
    return {"activate",
            {{"app_id", activation.app_id},
             {"api_level", activation.api_level},
             {"sdk_version", activation.version},
             {"sdk_version_text", version_text(activation.version)},
             {"bundle_id", text_of(activation.bundle_id)}}};
  }
  Description operator()(const protocol::TelemetryFrequency&) const {
    return {"set_broadcast_frequency", frequency_fields(value)};
  }
  Description operator()(const protocol::ToMobile& to) const {
    return {"to_mobile", {{"data_hex", to_hex(to.data.view())}}};
  }
  Description operator()(const protocol::ControlRequest& request) const {
    return {request.obtain ? "obtain_control" : "release_control", {{"request", request.obtain ? 1 : 0}}};
  }
  Description operator()(const protocol::TaskRequest& request) const {
    const char* const name = request.task == protocol::Task::kTakeOff ? "task_takeoff"
                             : request.task == protocol::Task::kLand  ? "task_land"
                                                                      : "task_go_home";
    return {name, {{"task_seq", request.sequence}, {"task", static_cast<int>(request.task)}}};
  }
  Description operator()(const protocol::TaskQuery& query) const {
    return {"task_query", {{"task_seq", query.sequence}}};
  }
  Description operator()(const protocol::MotorRequest& request) const {
    return {request.start ? "arm" : "disarm", {{"arm", request.start ? 1 : 0}}};
  }
  Description operator()(const protocol::Movement& movement) const { return {"movement", movement_fields(movement)}; }
  Description operator()(const protocol::GimbalRate& rate) const {
    return {"gimbal_rate",
            {{"yaw_decideg_s", rate.yaw_decideg_s},
             {"roll_decideg_s", rate.roll_decideg_s},
             {"pitch_decideg_s", rate.pitch_decideg_s},
             {"enable", rate.enable}}};
  }
  Description operator()(const protocol::GimbalAngle& angle) const {
    return {"gimbal_angle",
            {{"yaw_decideg", angle.yaw_decideg},
             {"roll_decideg", angle.roll_decideg},
             {"pitch_decideg", angle.pitch_decideg},
             {"flags", angle.flags},
             {"duration_ds", angle.duration_ds}}};
  }
  Description operator()(const protocol::CameraRequest& request) const {
    return {std::string(protocol::name(id_of(request))), {{"arbitrary", request.arbitrary}}};
  }
  Description operator()(const protocol::SyncPulse& pulse) const {
    return {"sync_frequency", {{"freq_hz", pulse.frequency_hz}}};
  }
  Description operator()(const protocol::VirtualRcSwitch& to) const {
    return {to.on ? "vrc_on" : "vrc_off",
            {{"enable", to.on ? 1 : 0}, {"cutoff_to_real_rc", to.fall_back_to_rc ? 1 : 0}, {"reserved", to.reserved}}};
  }
  Description operator()(const protocol::VirtualRcData& data) const {
    return {data.under_switch_id ? "vrc_data_under_switch_id" : "vrc_data", channel_fields(data)};
  }
};

struct PushDescriber {
  Description operator()(std::monostate) const { return {"unknown"}; }
  Description operator()(const protocol::ControlLost& lost) const { return {"lost_control", {{"value", lost.value}}}; }
  Description operator()(const protocol::FromMobile& from) const {
    return {"from_mobile", {{"data_hex", to_hex(from.data.view())}}};
  }
  Description operator()(const protocol::MissionStatus& status) const {
    return {"mission_status", {{"type", status.kind}, {"data_hex", to_hex(std::as_bytes(std::span(status.rest)))}}};
  }
  Description operator()(const protocol::WaypointEvent& event) const {
    return {"waypoint_event", {{"type", event.event}, {"data_hex", to_hex(std::as_bytes(std::span(event.rest)))}}};
  }
};

Json version_fields(const protocol::VersionAnswer& answer) {
  return {{"ack_code", answer.code},
          {"version_crc", answer.version_crc},
          {"device_id", text_of(answer.device_id)},
          {"version_name", text_of(answer.version_name)},
          {"activated", answer.activated()}};
}

Description describe_ack(const protocol::Message& message, const std::optional<MessageId>& answered) {
  Description description{answered ? "ack_" + std::string(protocol::name(*answered)) : "ack"};
  const bool may_be_version = !answered || *answered == ids::kVersionQuery;
  if (const auto version = protocol::decode_version_answer(message.value); version && may_be_version) {
    description.name = "ack_version_query";
    description.fields = version_fields(*version);
    return description;
  }
  if (const auto code = protocol::decode_ack(message.value); code) {
    description.fields["ack_code"] = *code;
    if (answered == ids::kControlRequest) {
      description.fields["meaning"] = protocol::ack_meaning(*answered, *code).name;
    }
    return description;
  }
  description.fields["data_hex"] = to_hex(message.value);
  return description;
}

Description malformed(MessageId id) { return {std::string(protocol::name(id)), Json::object(), true}; }

}  // namespace

Description describe(const protocol::Message& message, const std::optional<MessageId>& answered) {
  if (message.header.is_ack) {
    return describe_ack(message, answered);
  }
  if (!message.has_id) {
    return {"unknown"};
  }
  if (message.id == ids::kTelemetry) {
    protocol::Telemetry telemetry;
    return decode_telemetry(message.value, telemetry) == core::Status::kOk
               ? Description{"telemetry", telemetry_fields(telemetry)}
               : malformed(message.id);
  }
  if (const auto command = protocol::decode_command(message.id, message.value); command) {
    return std::visit(CommandDescriber{message.value}, *command);
  }
  if (const auto push = protocol::decode_push(message.id, message.value); push) {
    return std::visit(PushDescriber{}, *push);
  }
  return protocol::find(message.id) == nullptr ? Description{"unknown"} : malformed(message.id);
}

void CommandMemory::note(const protocol::Message& message) {
  if (!message.header.is_ack && message.has_id) {
    last_[message.header.session] = Entry{message.header.sequence, message.id};
  }
}

std::optional<MessageId> CommandMemory::command_of(const protocol::FrameHeader& ack) const {
  const std::optional<Entry>& entry = last_[ack.session];
  return ack.is_ack && entry && entry->sequence == ack.sequence ? std::optional(entry->id) : std::nullopt;
}

Json frame_line(const protocol::FrameView& frame, const protocol::Cipher* cipher, CommandMemory& memory) {
  protocol::CipherScratch scratch;
  const auto message = open(frame, cipher, scratch);
  Json line{{"offset", frame.offset},
            {"session", frame.header.session},
            {"is_ack", frame.header.is_ack},
            {"seq", frame.header.sequence},
            {"encrypted", frame.header.encrypted()},
            {"cmd_set", nullptr},
            {"cmd_id", nullptr},
            {"payload_hex", nullptr}};
  if (!message) {  // the key was not given
    line["name"] = "encrypted";
    line["fields"] = Json::object();
    line["ciphertext_hex"] = to_hex(frame.data);
    return line;
  }
  if (message->has_id) {
    line["cmd_set"] = message->id.set;
    line["cmd_id"] = message->id.id;
  }
  line["payload_hex"] = to_hex(message->value);
  const std::optional<MessageId> answered = memory.command_of(frame.header);
  const Description description = describe(*message, answered);
  line["name"] = description.name;
  line["fields"] = description.fields;
  if (frame.header.encrypted()) {
    line["padding_hex"] = to_hex(message->filler);
  }
  if (answered) {
    line["ack_for"] = {{"cmd_set", answered->set}, {"cmd_id", answered->id}};
  }
  if (description.malformed) {
    line["malformed"] = true;
  }
  memory.note(*message);
  return line;
}

}  // namespace m100::lab
