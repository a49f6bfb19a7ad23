// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "firmware/core/frames.h"
#include "firmware/core/time.h"
#include "firmware/est/consistency/velocity_consistency.h"
#include "firmware/est/measurement.h"
#include "protocol/dji/telemetry.h"

namespace m100::app {

/// Limits of a working sensor; readings outside are dropped and counted.
struct SensorLimits {
  float position_m = 100.F;           ///< on each axis: the estimator's own range
  float rate_rad_s = 20.F;            ///< on each axis: twice the estimator's range; 21 deg/s, not converted, is beyond
  float norm_error = 0.01F;           ///< of the length of the unit quaternion
  float tilt_rad = 1.2F;              ///< no flight tilts so far: more means swapped axes
  std::uint32_t stuck_readings = 50;  ///< bit-identical readings in a row: half a second of a sensor that is stuck
};

struct SensorAdapterStats {
  std::uint32_t refused_poses = 0;      ///< not finite, out of range, or captured later than now
  std::uint32_t refused_attitudes = 0;  ///< not a unit quaternion, tilted too far, or turning too fast
  std::uint32_t stuck_attitudes = 0;    ///< with the same numbers for SensorLimits::stuck_readings
  std::uint32_t repeated_poses = 0;     ///< the same bits as the pose before: not new, whatever its time stamp is
};

/// Telemetry and pose as one measurement in our frames: NED to world, FRD to body.
class SensorAdapter {
 public:
  explicit SensorAdapter(const SensorLimits& sensor_limits = {}) : sensor_limits_(sensor_limits) {}

  /// @param attitude_age age of the telemetry's attitude.
  /// @param disturbance_acceleration of the tick before: it is measured with that tick's estimate.
  template <typename T>
  est::Measurement<T> update(const protocol::Telemetry& telemetry, core::Duration attitude_age,
                             const core::Pose<double>& pose,
                             const est::DisturbanceAcceleration<T>& disturbance_acceleration, core::TimePoint now);

  /// The other motion data of the same package; the attitude is taken from `measured`, of this tick.
  template <typename T>
  static est::ImuSample<T> imu_sample(const protocol::Telemetry& telemetry, const est::Measurement<T>& measured);

  /// The world's vertical in body axes (FLU) by the newest attitude, plausible or not; nullopt: no (unit) quaternion.
  template <typename T>
  static std::optional<core::Vector<T, 3>> vertical_b(const protocol::Telemetry& telemetry);

  const SensorAdapterStats& stats() const { return stats_; }

 private:
  template <typename T>
  bool is_plausible(const protocol::Telemetry& telemetry, const core::Quaternion<T>& q, const core::Euler<T>& euler);
  template <typename T>
  bool is_plausible(const core::Pose<T>& pose, core::TimePoint now);
  bool is_repeated(const core::Pose<double>& pose);
  core::Duration since_last(const protocol::Telemetry& telemetry);

  SensorLimits sensor_limits_;
  SensorAdapterStats stats_;
  std::array<float, 7> last_reading_{};
  std::uint32_t same_readings_ = 0;
  std::uint32_t last_ticks_ = 0;  ///< of the autopilot's clock, of the newest attitude; 0: not known
  /// Bits of x, y, z, yaw of the last pose; at first those of a NaN.
  std::array<std::uint64_t, 4> last_pose_{~std::uint64_t{0}};
};

}  // namespace m100::app
