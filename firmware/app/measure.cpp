// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/app/measure.h"

#include "firmware/core/frames.h"

namespace m100::app {
namespace {

/// NaN and infinity fail it.
bool within(double value, double limit) { return value >= -limit && value <= limit; }

core::Quaternion<double> attitude_of(const protocol::Telemetry& telemetry) {
  return core::flip_yz(
      core::Quaternion<double>{static_cast<double>(telemetry.attitude[0]), static_cast<double>(telemetry.attitude[1]),
                               static_cast<double>(telemetry.attitude[2]), static_cast<double>(telemetry.attitude[3])});
}

core::Vector<double, 3> rates_of(const protocol::Telemetry& telemetry) {
  return core::flip_yz(core::Vector<double, 3>(static_cast<double>(telemetry.angular_velocity_frd_rad_s[0]),
                                               static_cast<double>(telemetry.angular_velocity_frd_rad_s[1]),
                                               static_cast<double>(telemetry.angular_velocity_frd_rad_s[2])));
}

template <typename T>
core::Vector<T, 3> vector_of(const std::array<float, 3>& numbers) {
  return {static_cast<T>(numbers[0]), static_cast<T>(numbers[1]), static_cast<T>(numbers[2])};
}

}  // namespace

bool Measure::believable(const protocol::Telemetry& telemetry, const core::Euler<double>& euler) {
  const std::array<float, 7> reading{telemetry.attitude[0],
                                     telemetry.attitude[1],
                                     telemetry.attitude[2],
                                     telemetry.attitude[3],
                                     telemetry.angular_velocity_frd_rad_s[0],
                                     telemetry.angular_velocity_frd_rad_s[1],
                                     telemetry.angular_velocity_frd_rad_s[2]};
  same_readings_ = reading == last_reading_ ? same_readings_ + 1 : 0;
  last_reading_ = reading;
  const core::Quaternion<double> q = attitude_of(telemetry);
  const double norm2 = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
  const core::Vector<double, 3> rates = rates_of(telemetry);
  const bool good = within(norm2 - 1.0, 2.0 * plausible_.norm_error) && within(rates.x(), plausible_.rate_rad_s) &&
                    within(rates.y(), plausible_.rate_rad_s) && within(rates.z(), plausible_.rate_rad_s) &&
                    within(euler.roll_rad, plausible_.tilt_rad) && within(euler.pitch_rad, plausible_.tilt_rad);
  const bool stuck = same_readings_ >= plausible_.stuck_readings;
  stats_.refused_attitudes += good ? 0U : 1U;
  stats_.stuck_attitudes += stuck ? 1U : 0U;
  return good && !stuck;
}

bool Measure::believable(const core::Pose<double>& pose, core::TimePoint now) {
  const bool good = within(pose.position_w_m.x(), plausible_.position_m) &&
                    within(pose.position_w_m.y(), plausible_.position_m) &&
                    within(pose.position_w_m.z(), plausible_.position_m) && within(pose.yaw_rad, 2.0 * core::kPi) &&
                    pose.captured_at() <= now;
  stats_.refused_poses += good ? 0U : 1U;
  // An aircraft in the air never gives the same bits twice; a capture that lost it does, with fresh stamps.
  const std::array<double, 4> seen{pose.position_w_m.x(), pose.position_w_m.y(), pose.position_w_m.z(), pose.yaw_rad};
  const bool repeated = good && seen == last_pose_;
  stats_.repeated_poses += repeated ? 1U : 0U;
  last_pose_ = good ? seen : last_pose_;
  return good && !repeated;
}

template <typename T>
est::Measurement<T> Measure::update(const protocol::Telemetry& telemetry, core::Duration attitude_age,
                                    const core::Pose<double>& pose, core::TimePoint now) {
  est::Measurement<T> measured;
  measured.now = now;
  if (pose.is_new && believable(pose, now)) {
    measured.pose = pose.template cast<T>();
    measured.pose.yaw_rad = static_cast<T>(core::wrap_pi(pose.yaw_rad));
  }
  if (!telemetry.has(protocol::TelemetryItem::kAttitude) || !telemetry.has(protocol::TelemetryItem::kAngularVelocity)) {
    return measured;
  }
  if (const core::Euler<double> euler = core::euler_of(attitude_of(telemetry)); believable(telemetry, euler)) {
    measured.attitude.is_new = true;
    measured.attitude.age = attitude_age;
    measured.attitude.roll_rad = static_cast<T>(euler.roll_rad);
    measured.attitude.pitch_rad = static_cast<T>(euler.pitch_rad);
    measured.attitude.yaw_rad = static_cast<T>(euler.yaw_rad);
    measured.attitude.rate_b_rad_s = rates_of(telemetry).template cast<T>();
  }
  return measured;
}

template <typename T>
est::Felt<T> Measure::felt(const protocol::Telemetry& telemetry, const est::Measurement<T>& measured) {
  est::Felt<T> felt;
  felt.attitude_is_new = measured.attitude.is_new;
  felt.roll_rad = measured.attitude.roll_rad;
  felt.pitch_rad = measured.attitude.pitch_rad;
  felt.yaw_rad = measured.attitude.yaw_rad;
  felt.rate_b_rad_s = measured.attitude.rate_b_rad_s;
  felt.force_is_new = felt.attitude_is_new && telemetry.has(protocol::TelemetryItem::kAcceleration);
  felt.force_b = core::flip_yz(vector_of<T>(telemetry.acceleration));
  const float down_m_s = telemetry.velocity_ned_m_s[2];
  // Exactly zero is what stands there while nothing is estimated.
  felt.climb_is_new = telemetry.has(protocol::TelemetryItem::kVelocity) && (down_m_s < 0.F || down_m_s > 0.F);
  felt.climb_m_s = -static_cast<T>(down_m_s);
  return felt;
}

template est::Felt<float> Measure::felt(const protocol::Telemetry&, const est::Measurement<float>&);
template est::Felt<double> Measure::felt(const protocol::Telemetry&, const est::Measurement<double>&);
template est::Measurement<float> Measure::update(const protocol::Telemetry&, core::Duration, const core::Pose<double>&,
                                                 core::TimePoint);
template est::Measurement<double> Measure::update(const protocol::Telemetry&, core::Duration, const core::Pose<double>&,
                                                  core::TimePoint);

}  // namespace m100::app
