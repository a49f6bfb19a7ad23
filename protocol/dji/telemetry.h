// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/core/expected.h"
#include "protocol/dji/catalogue.h"
#include "protocol/dji/value.h"

namespace m100::protocol {

/// One bit each in the flag word; the items follow it in this order, without gaps.
enum class TelemetryItem : std::uint16_t {
  kTime = 1U << 0U,
  kAttitude = 1U << 1U,
  kAcceleration = 1U << 2U,
  kVelocity = 1U << 3U,
  kAngularVelocity = 1U << 4U,
  kPosition = 1U << 5U,
  kMagnetometer = 1U << 6U,
  kRc = 1U << 7U,
  kGimbal = 1U << 8U,
  kFlightStatus = 1U << 9U,
  kBattery = 1U << 10U,
  kControl = 1U << 11U,
};

inline constexpr std::size_t kTelemetryItemCount = 12;
inline constexpr std::uint16_t kAllTelemetryItems = 0x0FFF;
/// Bytes of each item, in bit order (M100, firmware 3.1).
inline constexpr std::array<std::uint8_t, kTelemetryItemCount> kTelemetryItemBytes{9, 16, 12, 13, 12, 25,
                                                                                   6, 12, 13, 1,  1,  2};

/// The value of a telemetry push that carries these items: the flag word and the items.
constexpr std::size_t telemetry_value_bytes(std::uint16_t items) {
  std::size_t size = 2;
  for (std::size_t item = 0; item < kTelemetryItemCount; ++item) {
    size += ((static_cast<unsigned>(items) >> item) & 1U) != 0 ? std::size_t{kTelemetryItemBytes[item]} : 0U;
  }
  return size;
}
static_assert(telemetry_value_bytes(kAllTelemetryItems) == 124);

enum class FlightStatus : std::uint8_t {
  kMotorsOff = 0,  ///< later SDK headers
  kStandby = 1,
  kTakingOff = 2,
  kInAir = 3,
  kLanding = 4,
  kLanded = 5,
};

constexpr bool is_on_ground(FlightStatus status) {
  return status == FlightStatus::kMotorsOff || status == FlightStatus::kStandby || status == FlightStatus::kLanded;
}

/// The autopilot flies its own task: it ignores commands and keeps level.
constexpr bool is_own_task(FlightStatus status) {
  return status == FlightStatus::kTakingOff || status == FlightStatus::kLanding;
}

enum class ControlDevice : std::uint8_t { kRemoteController = 0, kMobileApp = 1, kOnboardComputer = 2 };

inline constexpr std::int16_t kRcModeP = -8000;
inline constexpr std::int16_t kRcModeA = 0;
inline constexpr std::int16_t kRcModeF = 8000;

/// The last telemetry of the flight controller, in DJI's own units and frames: ground frame NED (north, east, down),
/// body frame FRD (forward, right, down). The application converts it to ours.
struct Telemetry {
  /// Time by the 400 Hz clock of the flight controller.
  struct Time {
    std::uint32_t ticks = 0;        ///< of 2.5 ms
    std::uint32_t nanoseconds = 0;  ///< within the tick
    std::uint8_t sync = 0;          ///< 1: belongs to a sync pulse
  };
  struct Position {
    double latitude_rad = 0.;
    double longitude_rad = 0.;
    float altitude_m = 0.F;
    float height_m = 0.F;         ///< above the home point, or ultrasonic below 3 m
    std::uint8_t gps_health = 0;  ///< 0..5
  };
  /// The pilot's transmitter. Sticks -10000..10000; right, forward and up are positive.
  struct Rc {
    std::int16_t roll = 0;
    std::int16_t pitch = 0;
    std::int16_t yaw = 0;
    std::int16_t throttle = 0;
    std::int16_t mode = 0;  ///< -8000 P, 0 A, 8000 F
    std::int16_t gear = 0;  ///< -10000 up, -4545 down, 0 no transmitter
  };
  struct Gimbal {
    float roll_deg = 0.F;
    float pitch_deg = 0.F;
    float yaw_deg = 0.F;
    std::uint8_t limits = 0;  ///< bit 0 pitch, 1 roll, 2 yaw
  };
  struct Control {
    std::uint8_t mode = 0;  ///< 0 none, 1..18 movement modes
    std::uint8_t bits = 0;  ///< 0-2 device, 3 OES has requested, 4 virtual RC on
    ControlDevice device() const { return static_cast<ControlDevice>(bits & 7U); }
    bool virtual_rc_on() const { return (bits & 16U) != 0; }
  };

  std::uint16_t items = 0;  ///< flag word: members that the last package had; SerialLink joins those of a tick
  Time time;
  std::array<float, 4> attitude{1.F, 0.F, 0.F, 0.F};  ///< unit quaternion, scalar first: v_ned = q v_frd q*
  std::array<float, 3> acceleration{};                ///< m/s^2 or g, NED or FRD: as set in DJI's assistant
  std::array<float, 3> velocity_ned_m_s{};
  std::uint8_t velocity_status = 0;  ///< bit 0 valid, 1-4 source, 5-7 reserved
  std::array<float, 3> angular_velocity_frd_rad_s{};
  Position position;
  std::array<std::int16_t, 3> magnetometer{};  ///< no unit given by DJI
  Rc rc;
  Gimbal gimbal;
  FlightStatus flight_status = FlightStatus::kMotorsOff;
  std::uint8_t battery_percent = 0;
  Control control;

  bool has(TelemetryItem item) const { return (items & static_cast<std::uint16_t>(item)) != 0; }
};

/// Decodes a package into telemetry. Members of items that it lacks keep their values; `items` names those that it has.
/// Numbers are not checked: the reader has to refuse a NaN.
/// @returns kInvalidArgument: the size does not fit the flag word exactly; telemetry is unchanged then.
core::Status decode_telemetry(std::span<const std::byte> value, Telemetry& telemetry);

/// Writes the items that telemetry.items names.
Value encode(const Telemetry& telemetry);

constexpr MessageId id_of(const Telemetry&) { return ids::kTelemetry; }

}  // namespace m100::protocol
