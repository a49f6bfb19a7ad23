// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace m100::companion::recording {

// The records of `m100 record`: telemetry items and poses in our frames (world NWU, body FLU), SI unless stated. Each
// timestamp is the sender's, converted to our clock [us] by ClockFit. No padding: each format states the same layout.

/// The pilot's transmitter. Sticks -10000..10000; positive is roll to the right, pitch forward, throttle up, yaw right.
struct Rc {
  std::uint64_t timestamp = 0;
  std::int16_t roll = 0, pitch = 0, throttle = 0, yaw = 0;
  std::int16_t mode = 0, gear = 0;
  std::uint32_t package = 0;  ///< number of the telemetry package, from 1; likewise below
  static constexpr std::string_view kFormat =
      "rc:uint64_t timestamp;int16_t roll;int16_t pitch;int16_t throttle;int16_t yaw;int16_t mode;int16_t gear;"
      "uint32_t package;";
};
static_assert(sizeof(Rc) == 24);

struct Attitude {
  std::uint64_t timestamp = 0;
  float roll = 0.F, pitch = 0.F, yaw = 0.F;  ///< rad, z-y-x
  std::uint32_t package = 0;
  static constexpr std::string_view kFormat =
      "attitude:uint64_t timestamp;float roll;float pitch;float yaw;uint32_t package;";
};
static_assert(sizeof(Attitude) == 24);

/// Three numbers along x, y, z.
struct Vector {
  std::uint64_t timestamp = 0;
  std::array<float, 3> xyz{};
  std::uint32_t package = 0;
};
static_assert(sizeof(Vector) == 24);
inline constexpr std::string_view kRatesFormat =
    "rates:uint64_t timestamp;float[3] xyz;uint32_t package;";  ///< body, rad/s
inline constexpr std::string_view kVelocityFormat =
    "velocity:uint64_t timestamp;float[3] xyz;uint32_t package;";  ///< world, m/s
/// Specific force in the body, in the unit that is set in DJI's assistant: g, or m/s^2.
inline constexpr std::string_view kForceFormat = "force:uint64_t timestamp;float[3] xyz;uint32_t package;";

struct Position {
  std::uint64_t timestamp = 0;
  double latitude = 0.0, longitude = 0.0;  ///< rad
  float altitude = 0.F, height = 0.F;      ///< m; the height is over the home point, or ultrasonic below 3 m
  std::uint32_t gps_health = 0, package = 0;
  static constexpr std::string_view kFormat =
      "position:uint64_t timestamp;double latitude;double longitude;float altitude;float height;uint32_t gps_health;"
      "uint32_t package;";
};
static_assert(sizeof(Position) == 40);

struct Status {
  std::uint64_t timestamp = 0;
  std::uint8_t flight_status = 0, battery_percent = 0, control_mode = 0, control_bits = 0;
  std::uint32_t package = 0;
  static constexpr std::string_view kFormat =
      "status:uint64_t timestamp;uint8_t flight_status;uint8_t battery_percent;uint8_t control_mode;"
      "uint8_t control_bits;uint32_t package;";
};
static_assert(sizeof(Status) == 16);

/// A pose; its timestamp is the time of capture.
struct Pose {
  std::uint64_t timestamp = 0;
  std::array<double, 3> xyz{};  ///< m
  double yaw = 0.0;             ///< rad
  std::uint64_t arrived = 0;    ///< us
  std::uint64_t sequence = 0;
  static constexpr std::string_view kFormat =
      "pose:uint64_t timestamp;double[3] xyz;double yaw;uint64_t arrived;uint64_t sequence;";
};
static_assert(sizeof(Pose) == 56);

}  // namespace m100::companion::recording
