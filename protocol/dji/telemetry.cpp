// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/dji/telemetry.h"

#include "protocol/bytes.h"

namespace m100::protocol {
namespace {

/// Value sizes by the lower and the upper six bits: 128 bytes, where all 4096 combinations would take 4 KiB.
constexpr std::array<std::array<std::uint8_t, 64>, 2> make_sizes() {
  std::array<std::array<std::uint8_t, 64>, 2> sizes{};
  for (unsigned bits = 0; bits < 64; ++bits) {
    for (unsigned item = 0; item < 6; ++item) {
      if (((bits >> item) & 1U) != 0) {
        sizes[0][bits] = static_cast<std::uint8_t>(sizes[0][bits] + kTelemetryItemBytes[item]);
        sizes[1][bits] = static_cast<std::uint8_t>(sizes[1][bits] + kTelemetryItemBytes[item + 6]);
      }
    }
  }
  return sizes;
}

constexpr auto kSizes = make_sizes();

/// Reads bytes in order; the caller has checked their number.
class Cursor {
 public:
  explicit Cursor(const std::byte* at) : at_(at) {}
  template <typename T>
  void take(T& value) {
    std::memcpy(&value, at_, sizeof(T));  // numbers and arrays of numbers are packed on the wire as in memory
    at_ += sizeof(T);
  }

 private:
  const std::byte* at_;
};

void take_position(Cursor& cursor, Telemetry::Position& position) {
  cursor.take(position.latitude_rad);
  cursor.take(position.longitude_rad);
  cursor.take(position.altitude_m);
  cursor.take(position.height_m);
  cursor.take(position.gps_health);
}

void take_rc(Cursor& cursor, Telemetry::Rc& rc) {
  cursor.take(rc.roll);
  cursor.take(rc.pitch);
  cursor.take(rc.yaw);
  cursor.take(rc.throttle);
  cursor.take(rc.mode);
  cursor.take(rc.gear);
}

void take_gimbal(Cursor& cursor, Telemetry::Gimbal& gimbal) {
  cursor.take(gimbal.roll_deg);
  cursor.take(gimbal.pitch_deg);
  cursor.take(gimbal.yaw_deg);
  cursor.take(gimbal.limits);
}

void take_motion(Cursor& cursor, Telemetry& telemetry) {
  if (telemetry.has(TelemetryItem::kTime)) {
    cursor.take(telemetry.time.ticks);
    cursor.take(telemetry.time.nanoseconds);
    cursor.take(telemetry.time.sync);
  }
  if (telemetry.has(TelemetryItem::kAttitude)) {
    cursor.take(telemetry.attitude);
  }
  if (telemetry.has(TelemetryItem::kAcceleration)) {
    cursor.take(telemetry.acceleration);
  }
  if (telemetry.has(TelemetryItem::kVelocity)) {
    cursor.take(telemetry.velocity_ned_m_s);
    cursor.take(telemetry.velocity_status);
  }
  if (telemetry.has(TelemetryItem::kAngularVelocity)) {
    cursor.take(telemetry.angular_velocity_frd_rad_s);
  }
  if (telemetry.has(TelemetryItem::kPosition)) {
    take_position(cursor, telemetry.position);
  }
}

void take_state(Cursor& cursor, Telemetry& telemetry) {
  if (telemetry.has(TelemetryItem::kMagnetometer)) {
    cursor.take(telemetry.magnetometer);
  }
  if (telemetry.has(TelemetryItem::kRc)) {
    take_rc(cursor, telemetry.rc);
  }
  if (telemetry.has(TelemetryItem::kGimbal)) {
    take_gimbal(cursor, telemetry.gimbal);
  }
  if (telemetry.has(TelemetryItem::kFlightStatus)) {
    cursor.take(telemetry.flight_status);
  }
  if (telemetry.has(TelemetryItem::kBattery)) {
    cursor.take(telemetry.battery_percent);
  }
  if (telemetry.has(TelemetryItem::kControl)) {
    cursor.take(telemetry.control.mode);
    cursor.take(telemetry.control.bits);
  }
}

void put_motion(ByteWriter& writer, const Telemetry& telemetry) {
  if (telemetry.has(TelemetryItem::kTime)) {
    writer.put(telemetry.time.ticks);
    writer.put(telemetry.time.nanoseconds);
    writer.put(telemetry.time.sync);
  }
  if (telemetry.has(TelemetryItem::kAttitude)) {
    writer.put(telemetry.attitude);
  }
  if (telemetry.has(TelemetryItem::kAcceleration)) {
    writer.put(telemetry.acceleration);
  }
  if (telemetry.has(TelemetryItem::kVelocity)) {
    writer.put(telemetry.velocity_ned_m_s);
    writer.put(telemetry.velocity_status);
  }
  if (telemetry.has(TelemetryItem::kAngularVelocity)) {
    writer.put(telemetry.angular_velocity_frd_rad_s);
  }
  if (telemetry.has(TelemetryItem::kPosition)) {
    writer.put(telemetry.position.latitude_rad);
    writer.put(telemetry.position.longitude_rad);
    writer.put(telemetry.position.altitude_m);
    writer.put(telemetry.position.height_m);
    writer.put(telemetry.position.gps_health);
  }
}

void put_state(ByteWriter& writer, const Telemetry& telemetry) {
  if (telemetry.has(TelemetryItem::kMagnetometer)) {
    writer.put(telemetry.magnetometer);
  }
  if (telemetry.has(TelemetryItem::kRc)) {
    const Telemetry::Rc& rc = telemetry.rc;
    writer.put(std::array{rc.roll, rc.pitch, rc.yaw, rc.throttle, rc.mode, rc.gear});
  }
  if (telemetry.has(TelemetryItem::kGimbal)) {
    writer.put(std::array{telemetry.gimbal.roll_deg, telemetry.gimbal.pitch_deg, telemetry.gimbal.yaw_deg});
    writer.put(telemetry.gimbal.limits);
  }
  if (telemetry.has(TelemetryItem::kFlightStatus)) {
    writer.put(static_cast<std::uint8_t>(telemetry.flight_status));
  }
  if (telemetry.has(TelemetryItem::kBattery)) {
    writer.put(telemetry.battery_percent);
  }
  if (telemetry.has(TelemetryItem::kControl)) {
    writer.put(telemetry.control.mode);
    writer.put(telemetry.control.bits);
  }
}

}  // namespace

core::Status decode_telemetry(std::span<const std::byte> value, Telemetry& telemetry) {
  if (value.size() < sizeof(telemetry.items)) {
    return core::Status::kInvalidArgument;
  }
  const auto items = load<std::uint16_t>(value.data());
  if (value.size() != sizeof(items) + kSizes[0][items & 63U] + kSizes[1][(items >> 6U) & 63U]) {
    return core::Status::kInvalidArgument;
  }
  telemetry.items = items;
  Cursor cursor(value.data() + sizeof(items));
  take_motion(cursor, telemetry);
  take_state(cursor, telemetry);
  return core::Status::kOk;
}

Value encode(const Telemetry& telemetry) {
  return Value::of([&](ByteWriter& writer) {
    writer.put(telemetry.items);
    put_motion(writer, telemetry);
    put_state(writer, telemetry);
  });
}

}  // namespace m100::protocol
