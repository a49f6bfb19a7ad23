// SPDX-License-Identifier: BSD-3-Clause
// Encodes commands, after a check that every number is finite and inside its range.
#include "protocol/dji/commands.h"

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
    for (const Rate rate : command.rates) {
      writer.put(code(rate));
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

}  // namespace m100::protocol
