// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/autopilot/n1_movement.h"

#include <algorithm>
#include <cmath>

namespace m100::sim {
namespace {

constexpr double kGravity_m_s2 = 9.8066;
constexpr double kVelocityGain_per_s = 1.0;
constexpr double kPositionGain_per_s = 0.8;
constexpr double kPositionSpeed_m_s = 5.0;
constexpr double kHeightGain_per_s = 1.0;
constexpr double kClimbLimit_m_s = 4.0;
constexpr double kYawGain_per_s = 1.5;
constexpr double kYawRateLimit_rad_s = 100.0 * core::kDegree_rad;
constexpr double kTiltLimit_rad = 30.0 * core::kDegree_rad;
constexpr double kHoverThrust_percent = 33.0;  ///< 0.7389 * (3.3 kg g) + 8.945 (protocol, 6.4)
constexpr double kThrustGain_m_s_per_percent = 0.1;

using Vector2 = core::Vector<double, 2>;

double yaw_of(const VehicleState& state) { return core::euler_of(state.rotation_wb).yaw_rad; }

/// DJI's x, y (north, east or forward, right) in the world NWU.
Vector2 to_world(const protocol::Movement& movement, const protocol::MovementMode& mode, const VehicleState& state) {
  const Vector2 flu(static_cast<double>(movement.x), -static_cast<double>(movement.y));
  return mode.frame == protocol::HorizontalFrame::kBody ? core::rotate_by_yaw(flu, yaw_of(state)) : flu;
}

}  // namespace

bool N1Movement::expire(core::TimePoint now, core::Duration timeout) {
  const bool expires = active_ && now - set_at_ > timeout;
  active_ = active_ && !expires;
  return expires;
}

void N1Movement::set(const protocol::Movement& movement, const VehicleState& state, core::TimePoint now) {
  active_ = true;
  set_at_ = now;
  movement_ = movement;
  mode_ = *protocol::movement_mode(movement.flag);
  if (mode_.horizontal == protocol::HorizontalMode::kPosition) {
    target_w_m_ = state.position_w_m.head<2>() + to_world(movement, mode_, state);
  }
}

MovementInput N1Movement::input(const VehicleState& state) const {
  MovementInput input;
  const double yaw_rad = yaw_of(state);
  if (mode_.horizontal == protocol::HorizontalMode::kAngle) {
    // The tilt is one rotation about a horizontal axis: (roll, pitch) turn like a vector.
    Vector2 tilt_rad(static_cast<double>(movement_.x) * core::kDegree_rad,
                     -static_cast<double>(movement_.y) * core::kDegree_rad);
    if (mode_.frame == protocol::HorizontalFrame::kGround) {
      tilt_rad = core::rotate_by_yaw(tilt_rad, -yaw_rad);
    }
    input.roll_rad = tilt_rad.x();
    input.pitch_rad = tilt_rad.y();
  } else {
    const bool by_position = mode_.horizontal == protocol::HorizontalMode::kPosition;
    Vector2 wanted_w_m_s = to_world(movement_, mode_, state);
    if (by_position) {
      wanted_w_m_s = kPositionGain_per_s * (target_w_m_ - state.position_w_m.head<2>());
      const double speed_m_s = wanted_w_m_s.norm();
      wanted_w_m_s *= speed_m_s > kPositionSpeed_m_s ? kPositionSpeed_m_s / speed_m_s : 1.0;
    }
    const Vector2 error_w_m_s = wanted_w_m_s - state.velocity_w_m_s.head<2>();
    const Vector2 a_b_m_s2 = kVelocityGain_per_s * core::rotate_by_yaw(error_w_m_s, -yaw_rad);
    input.pitch_rad = std::clamp(std::atan(a_b_m_s2.x() / kGravity_m_s2), -kTiltLimit_rad, kTiltLimit_rad);
    input.roll_rad = std::clamp(-std::atan(a_b_m_s2.y() / kGravity_m_s2), -kTiltLimit_rad, kTiltLimit_rad);
  }
  const double z = static_cast<double>(movement_.z);
  switch (mode_.vertical) {
    case protocol::VerticalMode::kVelocity:
      input.climb_m_s = z;
      break;
    case protocol::VerticalMode::kPosition:
      input.climb_m_s = kHeightGain_per_s * (z - state.position_w_m.z());
      break;
    case protocol::VerticalMode::kThrust:
      input.climb_m_s = kThrustGain_m_s_per_percent * (z - kHoverThrust_percent);
      break;
  }
  input.climb_m_s = std::clamp(input.climb_m_s, -kClimbLimit_m_s, kClimbLimit_m_s);
  const double clockwise_rad = static_cast<double>(movement_.yaw) * core::kDegree_rad;
  input.yaw_rate_rad_s = mode_.yaw == protocol::YawMode::kRate
                             ? -clockwise_rad
                             : std::clamp(kYawGain_per_s * core::wrap_pi(-clockwise_rad - yaw_rad),
                                          -kYawRateLimit_rad_s, kYawRateLimit_rad_s);
  return input;
}

}  // namespace m100::sim
