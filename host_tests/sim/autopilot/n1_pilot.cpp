// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/autopilot/n1_pilot.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace m100::sim {
namespace {

constexpr double kGravity_m_s2 = 9.8066;
constexpr double kSpeedGain_per_s = 2.0;
constexpr double kPlaceGain_per_s2 = 1.2;
constexpr double kIntegralGain_per_s3 = 0.2;
constexpr double kClimbGain_per_s = 1.0;
constexpr double kClimbLimit_m_s = 1.0;
constexpr double kFeelsAir_s = 0.3;
constexpr double kStopped_m_s = 0.3;
constexpr double kTiltLimit_rad = 25.0 * core::kDegree_rad;
constexpr double kTiltScale_rad_per_count = 9.23e-4;    // of the measured aircraft, see plant.cpp
constexpr double kClimbScale_m_s_per_count = 3.579e-3;  // likewise
constexpr double kTravel_counts = 660.0;

double stick(double resting, double counts) {
  return std::clamp(resting + counts, 1024.0 - kTravel_counts, 1024.0 + kTravel_counts);
}

}  // namespace

double N1StickMove::length_s() const {
  switch (shape) {
    case Shape::kDoublet:
      return 2.0 * seconds;
    case Shape::k3211:
      return 7.0 * seconds;
    case Shape::kStep:
    case Shape::kChirp:
      break;
  }
  return seconds;
}

double N1StickMove::offset_counts(double t_s) const {
  switch (shape) {
    case Shape::kDoublet:
      return t_s < seconds ? counts : -counts;
    case Shape::k3211: {
      const double unit = t_s / seconds;
      return unit < 3.0 || (unit >= 5.0 && unit < 6.0) ? counts : -counts;
    }
    case Shape::kChirp: {
      const double turns = from_hz * t_s + 0.5 * (to_hz - from_hz) * t_s * t_s / seconds;
      return counts * std::sin(2.0 * std::numbers::pi * turns);
    }
    case Shape::kStep:
      break;
  }
  return counts;
}

bool N1Pilot::tilts() const {
  return moves_[static_cast<std::size_t>(N1StickMove::Stick::kRoll)] ||
         moves_[static_cast<std::size_t>(N1StickMove::Stick::kPitch)];
}

double N1Pilot::flown(N1StickMove::Stick stick, double resting, double otherwise, double step_s) {
  std::optional<Moving>& moving = moves_[static_cast<std::size_t>(stick)];
  if (moving && moving->since_s >= moving->move.length_s()) {
    moving.reset();
  }
  if (!moving) {
    return otherwise;
  }
  const double offset = moving->move.offset_counts(moving->since_s);
  moving->since_s += step_s;
  return std::clamp(resting + offset, 1024.0 - kTravel_counts, 1024.0 + kTravel_counts);
}

void N1Pilot::stop() {
  moves_ = {};
  place_w_m_.reset();
  integral_w_ms_.setZero();
  air_w_m_s2_.reset();
}

StickInput N1Pilot::fly(const VehicleState& state, core::Duration step) {
  const double step_s = core::seconds<double>(step);
  const double yaw_rad = core::euler_of(state.rotation_wb).yaw_rad;
  const Vector2 sensed_w_m_s2 = core::rotate_by_yaw(Vector2(state.specific_force_b_m_s2.head<2>()), yaw_rad);
  air_w_m_s2_ =
      air_w_m_s2_ ? Vector2(*air_w_m_s2_ + step_s / kFeelsAir_s * (sensed_w_m_s2 - *air_w_m_s2_)) : sensed_w_m_s2;
  const Vector2 velocity_w_m_s = state.velocity_w_m_s.head<2>();
  if (!place_w_m_ && velocity_w_m_s.norm() < kStopped_m_s) {
    place_w_m_ = state.position_w_m;
  }
  Vector2 wanted_w_m_s2 = -kSpeedGain_per_s * velocity_w_m_s - *air_w_m_s2_;
  double climb_m_s = 0.0;
  if (place_w_m_) {
    const Vector2 away_m = (state.position_w_m - *place_w_m_).head<2>();
    integral_w_ms_ += tilts() ? Vector2::Zero().eval() : Vector2(step_s * away_m);
    wanted_w_m_s2 -= kPlaceGain_per_s2 * away_m + kIntegralGain_per_s3 * integral_w_ms_;
    climb_m_s =
        std::clamp(kClimbGain_per_s * (place_w_m_->z() - state.position_w_m.z()), -kClimbLimit_m_s, kClimbLimit_m_s);
  }
  const Vector2 wanted_b_m_s2 = core::rotate_by_yaw(wanted_w_m_s2, -yaw_rad);
  const auto tilt_counts = [](double a_m_s2) {
    return std::clamp(std::atan(a_m_s2 / kGravity_m_s2), -kTiltLimit_rad, kTiltLimit_rad) / kTiltScale_rad_per_count;
  };
  using Stick = N1StickMove::Stick;
  // Stick forward is nose down, stick right is right side down; the body's y points left.
  const double roll_vrc = stick(resting_.roll_vrc, tilt_counts(-wanted_b_m_s2.y()));
  const double pitch_vrc = stick(resting_.pitch_vrc, tilt_counts(wanted_b_m_s2.x()));
  const double throttle_vrc = stick(resting_.throttle_vrc, climb_m_s / kClimbScale_m_s_per_count);
  return {.roll_vrc = flown(Stick::kRoll, resting_.roll_vrc, roll_vrc, step_s),
          .pitch_vrc = flown(Stick::kPitch, resting_.pitch_vrc, pitch_vrc, step_s),
          .throttle_vrc = flown(Stick::kThrottle, resting_.throttle_vrc, throttle_vrc, step_s),
          .yaw_vrc = flown(Stick::kYaw, resting_.yaw_vrc, resting_.yaw_vrc, step_s)};
}

}  // namespace m100::sim
