// SPDX-License-Identifier: BSD-3-Clause
// Decodes commands at the flight controller's end: sizes and most enumerators are checked, ranges are not.
#include "protocol/dji/command_decoder.h"

#include <algorithm>

namespace m100::protocol {
namespace {

core::Expected<Command> reject() { return core::Status::kInvalidArgument; }

/// The last step of a decoder that reads fields: the value, if the size of the message fitted exactly.
template <typename T>
core::Expected<Command> finish(const ByteReader& reader, const T& command) {
  return reader.complete() ? core::Expected<Command>(Command(command)) : reject();
}

core::Expected<Command> decode_flag(MessageId id, std::uint8_t flag) {
  if (flag > 1) {
    return reject();
  }
  return id == ids::kControlRequest ? Command(ControlRequest{flag == 1}) : Command(MotorRequest{flag == 1});
}

core::Expected<Command> decode_frequency(ByteReader reader) {
  TelemetryFrequency command;
  for (Rate& rate : command.rates) {
    rate = static_cast<Rate>(std::min(reader.take<std::uint8_t>(), static_cast<std::uint8_t>(Rate::kAsItIs)));
  }
  return finish(reader, command);
}

core::Expected<Command> decode_activation(ByteReader reader) {
  Activation command;
  command.app_id = reader.take<std::uint32_t>();
  command.api_level = reader.take<std::uint32_t>();
  command.version = reader.take<std::uint32_t>();
  reader.take(command.bundle_id);
  return finish(reader, command);
}

core::Expected<Command> decode_task(ByteReader reader) {
  const auto sequence = reader.take<std::uint8_t>();
  const auto task = static_cast<Task>(reader.take<std::uint8_t>());
  if (task != Task::kGoHome && task != Task::kTakeOff && task != Task::kLand) {
    return reject();
  }
  return finish(reader, TaskRequest{sequence, task});
}

core::Expected<Command> decode_movement(ByteReader reader) {
  Movement command;
  command.flag = reader.take<std::uint8_t>();
  command.x = reader.take<float>();
  command.y = reader.take<float>();
  command.z = reader.take<float>();
  command.yaw = reader.take<float>();
  return finish(reader, command);
}

core::Expected<Command> decode_gimbal_rate(ByteReader reader) {
  GimbalRate command;
  command.yaw_decideg_s = reader.take<std::int16_t>();
  command.roll_decideg_s = reader.take<std::int16_t>();
  command.pitch_decideg_s = reader.take<std::int16_t>();
  command.enable = reader.take<std::uint8_t>();
  return finish(reader, command);
}

core::Expected<Command> decode_gimbal_angle(ByteReader reader) {
  GimbalAngle command;
  command.yaw_decideg = reader.take<std::int16_t>();
  command.roll_decideg = reader.take<std::int16_t>();
  command.pitch_decideg = reader.take<std::int16_t>();
  command.flags = reader.take<std::uint8_t>();
  command.duration_ds = reader.take<std::uint8_t>();
  return finish(reader, command);
}

core::Expected<Command> decode_vrc_data(ByteReader reader, bool under_switch_id) {
  VirtualRcData command;
  reader.take(command.channels);
  command.under_switch_id = under_switch_id;
  return finish(reader, command);
}

core::Expected<Command> decode_to_mobile(std::span<const std::byte> value) {
  static_assert(find(ids::kToMobile)->max_value_bytes == MobileData::kMaxBytes);  // the size was checked before
  ToMobile command;
  std::copy(value.begin(), value.end(), command.data.bytes.begin());
  command.data.size = static_cast<std::uint8_t>(value.size());
  return Command(command);
}

core::Expected<Command> decode_vrc_switch(std::span<const std::byte> value) {
  ByteReader reader(value);
  if (value.size() == sizeof(VirtualRcData::channels)) {
    return decode_vrc_data(reader, true);
  }
  const auto bits = reader.take<std::uint8_t>();
  return finish(reader, VirtualRcSwitch{.on = (bits & 1U) != 0,
                                        .fall_back_to_rc = (bits & 2U) != 0,
                                        .reserved = static_cast<std::uint8_t>(bits >> 2U)});
}

core::Expected<Command> decode_sync(std::span<const std::byte> value) {
  ByteReader reader(value);
  const SyncPulse command{.frequency_hz = reader.take<std::uint32_t>()};
  if (value.size() == 6) {  // SDK 3.3 and later add a tag
    reader.take<std::uint16_t>();
  }
  return finish(reader, command);
}

}  // namespace

core::Expected<Command> decode_command(MessageId id, std::span<const std::byte> value) {
  const MessageInfo* const info = find(id);
  if (info == nullptr || info->direction != Direction::kToController || value.size() < info->min_value_bytes ||
      value.size() > info->max_value_bytes) {
    return reject();
  }
  ByteReader reader(value);
  const std::uint8_t first = value.empty() ? std::uint8_t{0} : std::to_integer<std::uint8_t>(value[0]);
  switch (static_cast<unsigned>(id.set) << 8U | id.id) {
    case 0x0000:
      return Command(VersionQuery{first});
    case 0x0001:
      return decode_activation(reader);
    case 0x0010:
      return decode_frequency(reader);
    case 0x00FE:
      return decode_to_mobile(value);
    case 0x0100:
    case 0x0105:
      return decode_flag(id, first);
    case 0x0101:
      return decode_task(reader);
    case 0x0102:
      return Command(TaskQuery{first});
    case 0x0103:
      return decode_movement(reader);
    case 0x011A:
      return decode_gimbal_rate(reader);
    case 0x011B:
      return decode_gimbal_angle(reader);
    case 0x0120:
    case 0x0121:
    case 0x0122:
      return Command(CameraRequest{static_cast<CameraAction>(id.id), first});
    case 0x0400:
      return decode_sync(value);
    case 0x0500:
      return decode_vrc_switch(value);
    case 0x0501:
      return decode_vrc_data(reader, false);
    default:
      return reject();
  }
}

}  // namespace m100::protocol
