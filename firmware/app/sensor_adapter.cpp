// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/app/sensor_adapter.h"

#include <bit>

#include "firmware/core/frames.h"
#include "firmware/link/telemetry/telemetry_clock.h"

namespace m100::app {
namespace {

constexpr float kMaxHeight_m = 1e4F;

/// False for NaN and infinity.
template <typename T>
bool within(T value, T limit) {
  return value >= -limit && value <= limit;
}

template <typename T>
core::Quaternion<T> attitude_of(const protocol::Telemetry& telemetry) {
  return core::flip_yz(core::Quaternion<T>{static_cast<T>(telemetry.attitude[0]), static_cast<T>(telemetry.attitude[1]),
                                           static_cast<T>(telemetry.attitude[2]),
                                           static_cast<T>(telemetry.attitude[3])});
}

template <typename T>
core::Vector<T, 3> vector_of(const std::array<float, 3>& numbers) {
  return {static_cast<T>(numbers[0]), static_cast<T>(numbers[1]), static_cast<T>(numbers[2])};
}

}  // namespace

template <typename T>
bool SensorAdapter::is_plausible(const protocol::Telemetry& telemetry, const core::Quaternion<T>& q,
                                 const core::Euler<T>& euler) {
  const std::array<float, 7> reading{telemetry.attitude[0],
                                     telemetry.attitude[1],
                                     telemetry.attitude[2],
                                     telemetry.attitude[3],
                                     telemetry.angular_velocity_frd_rad_s[0],
                                     telemetry.angular_velocity_frd_rad_s[1],
                                     telemetry.angular_velocity_frd_rad_s[2]};
  same_readings_ = reading == last_reading_ ? same_readings_ + 1 : 0;
  last_reading_ = reading;
  const T norm2 = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
  const auto most = [](float bound) { return static_cast<T>(bound); };
  bool good = within(norm2 - T(1), most(2.F * sensor_limits_.norm_error)) &&
              within(euler.roll_rad, most(sensor_limits_.tilt_rad)) &&
              within(euler.pitch_rad, most(sensor_limits_.tilt_rad));
  for (const float rate_rad_s : telemetry.angular_velocity_frd_rad_s) {
    good = good && within(rate_rad_s, sensor_limits_.rate_rad_s);
  }
  const bool stuck = same_readings_ >= sensor_limits_.stuck_readings;
  stats_.refused_attitudes += good ? 0U : 1U;
  stats_.stuck_attitudes += stuck ? 1U : 0U;
  return good && !stuck;
}

/// An aircraft in the air never gives the same bits twice; a motion capture that lost it does, with new time stamps.
bool SensorAdapter::is_repeated(const core::Pose<double>& pose) {
  const std::array<std::uint64_t, 4> seen{
      std::bit_cast<std::uint64_t>(pose.position_w_m.x()), std::bit_cast<std::uint64_t>(pose.position_w_m.y()),
      std::bit_cast<std::uint64_t>(pose.position_w_m.z()), std::bit_cast<std::uint64_t>(pose.yaw_rad)};
  const bool repeated = seen == last_pose_;
  stats_.repeated_poses += repeated ? 1U : 0U;
  last_pose_ = seen;
  return repeated;
}

template <typename T>
bool SensorAdapter::is_plausible(const core::Pose<T>& pose, core::TimePoint now) {
  const T most_m = static_cast<T>(sensor_limits_.position_m);
  const bool good = within(pose.position_w_m.x(), most_m) && within(pose.position_w_m.y(), most_m) &&
                    within(pose.position_w_m.z(), most_m) && within(pose.yaw_rad, static_cast<T>(2.0 * core::kPi)) &&
                    pose.captured_at() <= now;
  stats_.refused_poses += good ? 0U : 1U;
  return good;
}

/// Time between attitudes by the autopilot's clock; zero: not known, or more than a second: that clock was set.
core::Duration SensorAdapter::since_last(const protocol::Telemetry& telemetry) {
  const std::uint32_t ticks = telemetry.has(protocol::TelemetryItem::kTime) ? telemetry.time.ticks : 0U;
  const core::Duration passed = (ticks - last_ticks_) * link::TelemetryClock::kTick;
  const bool is_known = ticks != 0 && last_ticks_ != 0 && passed <= std::chrono::seconds(1);
  last_ticks_ = ticks;
  return is_known ? passed : core::Duration{0};
}

template <typename T>
est::Measurement<T> SensorAdapter::update(const protocol::Telemetry& telemetry, core::Duration attitude_age,
                                          const core::Pose<double>& pose,
                                          const est::DisturbanceAcceleration<T>& disturbance_acceleration,
                                          core::TimePoint now) {
  est::Measurement<T> measured;
  measured.now = now;
  measured.disturbance_acceleration = disturbance_acceleration;
  if (pose.is_new) {
    const core::Pose<T> came = pose.template cast<T>();
    if (is_plausible(came, now) && !is_repeated(pose)) {
      measured.pose = came;
      measured.pose.yaw_rad = core::wrap_pi(came.yaw_rad);
    }
  }
  if (!telemetry.has(protocol::TelemetryItem::kAttitude) || !telemetry.has(protocol::TelemetryItem::kAngularVelocity)) {
    return measured;
  }
  const core::Quaternion<T> attitude = attitude_of<T>(telemetry);
  if (const core::Euler<T> euler = core::euler_of(attitude); is_plausible(telemetry, attitude, euler)) {
    measured.attitude.is_new = true;
    measured.attitude.age = attitude_age;
    measured.attitude.since_last = since_last(telemetry);
    measured.attitude.roll_rad = euler.roll_rad;
    measured.attitude.pitch_rad = euler.pitch_rad;
    measured.attitude.yaw_rad = euler.yaw_rad;
    measured.attitude.rate_b_rad_s = core::flip_yz(vector_of<T>(telemetry.angular_velocity_frd_rad_s));
  }
  return measured;
}

template <typename T>
est::ImuSample<T> SensorAdapter::imu_sample(const protocol::Telemetry& telemetry, const est::Measurement<T>& measured) {
  est::ImuSample<T> imu_sample;
  imu_sample.attitude_is_new = measured.attitude.is_new;
  imu_sample.since_last_s = core::seconds<T>(measured.attitude.since_last);
  imu_sample.roll_rad = measured.attitude.roll_rad;
  imu_sample.pitch_rad = measured.attitude.pitch_rad;
  imu_sample.yaw_rad = measured.attitude.yaw_rad;
  imu_sample.sin_cos = measured.attitude.sin_cos;
  imu_sample.rate_b_rad_s = measured.attitude.rate_b_rad_s;
  imu_sample.force_is_new = imu_sample.attitude_is_new && telemetry.has(protocol::TelemetryItem::kAcceleration);
  imu_sample.force_b = core::flip_yz(vector_of<T>(telemetry.acceleration));
  const float down_m_s = telemetry.velocity_ned_m_s[2];
  // The field is exactly zero while the autopilot has no estimate.
  imu_sample.climb_is_new = telemetry.has(protocol::TelemetryItem::kVelocity) && (down_m_s < 0.F || down_m_s > 0.F);
  imu_sample.climb_m_s = -static_cast<T>(down_m_s);
  const float height_m = telemetry.position.height_m;
  imu_sample.height_is_new = telemetry.has(protocol::TelemetryItem::kPosition) && within(height_m, kMaxHeight_m);
  imu_sample.height_m = static_cast<T>(height_m);
  return imu_sample;
}

template <typename T>
std::optional<core::Vector<T, 3>> SensorAdapter::vertical_b(const protocol::Telemetry& telemetry) {
  const core::Quaternion<T> q = attitude_of<T>(telemetry);
  const T norm2 = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
  if (!telemetry.has(protocol::TelemetryItem::kAttitude) ||
      !within(norm2 - T(1), static_cast<T>(2.F * SensorLimits{}.norm_error))) {
    return std::nullopt;
  }
  return core::up_in_body(q);
}

template std::optional<core::Vector<float, 3>> SensorAdapter::vertical_b(const protocol::Telemetry&);
template std::optional<core::Vector<double, 3>> SensorAdapter::vertical_b(const protocol::Telemetry&);
template est::ImuSample<float> SensorAdapter::imu_sample(const protocol::Telemetry&, const est::Measurement<float>&);
template est::ImuSample<double> SensorAdapter::imu_sample(const protocol::Telemetry&, const est::Measurement<double>&);
template est::Measurement<float> SensorAdapter::update(const protocol::Telemetry&, core::Duration,
                                                       const core::Pose<double>&,
                                                       const est::DisturbanceAcceleration<float>&, core::TimePoint);
template est::Measurement<double> SensorAdapter::update(const protocol::Telemetry&, core::Duration,
                                                        const core::Pose<double>&,
                                                        const est::DisturbanceAcceleration<double>&, core::TimePoint);

}  // namespace m100::app
