// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/commands.h"

#include <algorithm>

namespace m100::protocol {
namespace {

template <typename T>
constexpr std::uint8_t code(T value) {
  return static_cast<std::uint8_t>(value);
}

/// False for a NaN too.
constexpr bool within(float value, float low, float high) { return value >= low && value <= high; }

constexpr bool within(int value, int limit) { return value >= -limit && value <= limit; }

constexpr float kHuge = 3.0e38F;  // "no limit", but finite

core::Expected<Command> reject() { return core::Status::kInvalidArgument; }

/// What every decoder ends with: the value if all bytes were there and none is left.
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
    rate = static_cast<Rate>(std::min(reader.take<std::uint8_t>(), code(Rate::kAsItIs)));
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
  if (value.size() > MobileData::kMaxBytes) {
    return reject();
  }
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

core::Status check_horizontal(HorizontalMode mode, float value) {
  const float limit = mode == HorizontalMode::kAngle ? 30.F : (mode == HorizontalMode::kVelocity ? 10.F : kHuge);
  return within(value, -limit, limit) ? core::Status::kOk : core::Status::kOutOfRange;
}

bool vertical_in_range(VerticalMode mode, float value) {
  switch (mode) {
    case VerticalMode::kVelocity:
      return within(value, -4.F, 4.F);
    case VerticalMode::kPosition:
      return within(value, 0.F, kHuge);
    case VerticalMode::kThrust:
      return within(value, 10.F, 100.F);
  }
  return false;
}

}  // namespace

core::Expected<MovementMode> movement_mode(std::uint8_t flag) {
  const unsigned horizontal = flag >> 6U;
  const unsigned vertical = (flag >> 4U) & 3U;
  const unsigned frame = (flag >> 1U) & 3U;
  const bool thrust_without_angle = vertical == 2 && horizontal != 0;
  if (horizontal > 2 || vertical > 2 || frame > 1 || thrust_without_angle) {
    return core::Status::kInvalidArgument;
  }
  return MovementMode{.horizontal = static_cast<HorizontalMode>(horizontal),
                      .vertical = static_cast<VerticalMode>(vertical),
                      .yaw = static_cast<YawMode>((flag >> 3U) & 1U),
                      .frame = static_cast<HorizontalFrame>(frame),
                      .stable = (flag & 1U) != 0};
}

core::Status check(const Movement& command) {
  const core::Expected<MovementMode> mode = movement_mode(command.flag);
  if (!mode) {
    return mode.status();
  }
  const float yaw_limit = mode->yaw == YawMode::kAngle ? 180.F : 100.F;
  const bool good = check_horizontal(mode->horizontal, command.x) == core::Status::kOk &&
                    check_horizontal(mode->horizontal, command.y) == core::Status::kOk &&
                    vertical_in_range(mode->vertical, command.z) && within(command.yaw, -yaw_limit, yaw_limit);
  return good ? core::Status::kOk : core::Status::kOutOfRange;
}

core::Status check(const VirtualRcData& command) {
  const bool good = std::all_of(command.channels.begin(), command.channels.end(), [](std::uint32_t channel) {
    return channel >= kStickLow_counts && channel <= kStickHigh_counts;
  });
  return good ? core::Status::kOk : core::Status::kOutOfRange;
}

core::Expected<Value> encode(const VersionQuery& command) {
  return Value::of([&](ByteWriter& writer) { writer.put(command.arbitrary); });
}

core::Expected<Value> encode(const Activation& command) {
  return Value::of([&](ByteWriter& writer) {
    writer.put(command.app_id);
    writer.put(command.api_level);
    writer.put(command.version);
    writer.put(command.bundle_id);
  });
}

core::Expected<Value> encode(const TelemetryFrequency& command) {
  const bool known = std::all_of(command.rates.begin(), command.rates.end(),
                                 [](Rate rate) { return code(rate) <= code(Rate::kAsItIs); });
  if (!known) {
    return core::Status::kOutOfRange;
  }
  return Value::of([&](ByteWriter& writer) {
    for (std::size_t item = 0; item < command.rates.size(); ++item) {
      writer.put(item < 12 ? code(command.rates[item]) : std::uint8_t{0});
    }
  });
}

core::Expected<Value> encode(const ToMobile& command) {
  if (command.data.size > MobileData::kMaxBytes) {
    return core::Status::kOutOfRange;
  }
  return Value::of([&](ByteWriter& writer) { writer.put(command.data.view()); });
}

core::Expected<Value> encode(const ControlRequest& command) {
  return Value::of([&](ByteWriter& writer) { writer.put(code(command.obtain)); });
}

core::Expected<Value> encode(const TaskRequest& command) {
  return Value::of([&](ByteWriter& writer) {
    writer.put(command.sequence);
    writer.put(code(command.task));
  });
}

core::Expected<Value> encode(const TaskQuery& command) {
  return Value::of([&](ByteWriter& writer) { writer.put(command.sequence); });
}

core::Expected<Value> encode(const MotorRequest& command) {
  return Value::of([&](ByteWriter& writer) { writer.put(code(command.start)); });
}

core::Expected<Value> encode(const Movement& command) {
  if (const core::Status status = check(command); status != core::Status::kOk) {
    return status;
  }
  return Value::of([&](ByteWriter& writer) {
    writer.put(command.flag);
    writer.put(command.x);
    writer.put(command.y);
    writer.put(command.z);
    writer.put(command.yaw);
  });
}

core::Expected<Value> encode(const GimbalRate& command) {
  if (!within(command.yaw_decideg_s, 1800) || !within(command.roll_decideg_s, 1800) ||
      !within(command.pitch_decideg_s, 1800)) {
    return core::Status::kOutOfRange;
  }
  return Value::of([&](ByteWriter& writer) {
    writer.put(command.yaw_decideg_s);
    writer.put(command.roll_decideg_s);
    writer.put(command.pitch_decideg_s);
    writer.put(command.enable);
  });
}

core::Expected<Value> encode(const GimbalAngle& command) {
  if (!within(command.yaw_decideg, 3200) || !within(command.roll_decideg, 350) || command.pitch_decideg < -900 ||
      command.pitch_decideg > 300) {
    return core::Status::kOutOfRange;
  }
  return Value::of([&](ByteWriter& writer) {
    writer.put(command.yaw_decideg);
    writer.put(command.roll_decideg);
    writer.put(command.pitch_decideg);
    writer.put(command.flags);
    writer.put(command.duration_ds);
  });
}

core::Expected<Value> encode(const CameraRequest& command) {
  return Value::of([&](ByteWriter& writer) { writer.put(command.arbitrary); });
}

core::Expected<Value> encode(const SyncPulse& command) {
  return Value::of([&](ByteWriter& writer) { writer.put(command.frequency_hz); });
}

core::Expected<Value> encode(const VirtualRcSwitch& command) {
  return Value::of([&](ByteWriter& writer) {
    const unsigned bits = (command.on ? 1U : 0U) | (command.fall_back_to_rc ? 2U : 0U);
    writer.put(static_cast<std::uint8_t>(bits | (static_cast<unsigned>(command.reserved) << 2U)));
  });
}

core::Expected<Value> encode(const VirtualRcData& command) {
  if (const core::Status status = check(command); status != core::Status::kOk) {
    return status;
  }
  return Value::of([&](ByteWriter& writer) { writer.put(command.channels); });
}

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
