// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/est/consistency/dead_reckoning.h"

#include "firmware/core/frames.h"
#include "firmware/core/maths.h"
#include "firmware/core/tilt.h"
#include "firmware/model/vehicle.h"

namespace m100::est {
namespace {

/// Time constant with which velocity and heading approach those of trusted poses. It is longer than it takes to detect
/// a sensor fault.
constexpr double kMemory_s = 4.0;
/// A pilot who is about to hand over hovers, within a few tenths of a m/s.
constexpr double kHovers_m_s = 1.0, kHoverMemory_s = 0.5;
constexpr double kDisturbanceMemory_s = 10.0;
constexpr double kFirstMean_s = 0.5;
constexpr double kGap_s = 0.05;  ///< if no attitude or no tick came for longer, the motion was not observed
constexpr double kSane = 1e6;
constexpr double kMax_m_s = 20.0;  ///< the velocity would diverge while poses are untrusted for minutes on the ground
/// Reported variance of the velocity: (0.4 m/s)^2.
constexpr double kVariance_m2_s2 = 0.16;

template <typename T>
T median(T a, T b, T c) {
  const T low = a < b ? a : b;
  const T high = a < b ? b : a;
  return core::clamp(c, low, high);
}

}  // namespace

template <typename T>
void DeadReckoning<T>::begin_if_due(const Estimate<T>& estimate, bool pilots) {
  const T all = velocity_w_m_s_.squaredNorm() + disturbance_acceleration_w_m_s2_.squaredNorm() +
                offset_rad_.squaredNorm() + tilt_acceleration_h_m_s2_.squaredNorm();
  if (!(all < static_cast<T>(kSane))) {  // not finite, and it would stay so
    seen_s_ = T(0);
    tilt_acceleration_h_m_s2_.setZero();
  }
  if (seen_s_ == T(0)) {
    velocity_w_m_s_ = pilots ? Vector2(Vector2::Zero()) : Vector2(estimate.x.velocity_m_s, estimate.y.velocity_m_s);
    disturbance_acceleration_w_m_s2_ = {estimate.x.disturbance_m_s2, estimate.y.disturbance_m_s2};
    offset_rad_ = {estimate.x.input_offset_rad, estimate.y.input_offset_rad};
  }
  if (seen_s_ == T(0) || pilots) {
    heading_rad_ = estimate.yaw_rad;
  }
}

template <typename T>
void DeadReckoning<T>::update(const ImuSample<T>& imu, const Estimate<T>& estimate,
                              const std::optional<Vector2>& measured_h_m_s2, bool trusted, bool pilots,
                              core::Duration elapsed) {
  if (!estimate.prediction_valid) {
    seen_s_ = T(0);
    return;
  }
  const T step_s = core::seconds<T>(elapsed);
  const Vector2 seen_m_s(estimate.x.velocity_m_s, estimate.y.velocity_m_s);
  const Vector2 estimated_m_s2(estimate.x.disturbance_m_s2, estimate.y.disturbance_m_s2);
  attitude_age_s_ = imu.attitude_is_new ? T(0) : core::clamp(attitude_age_s_ + step_s, T(0), T(1));
  if (imu.attitude_is_new) {
    slope_ = core::heading_slope_of(imu.roll(), imu.pitch());
  }
  begin_if_due(estimate, pilots);
  seen_s_ = core::clamp(seen_s_ + step_s, T(0), static_cast<T>(kDisturbanceMemory_s));
  heading_rad_ = core::wrap_pi(heading_rad_ + estimate.yaw_rate_rad_s * step_s);
  const core::SinCos<T> yaw = core::sin_cos_of(heading_rad_);
  const Vector2 tilted_h = slope_ * static_cast<T>(model::kGravity_m_s2);
  tilt_acceleration_h_m_s2_ += (tilted_h - tilt_acceleration_h_m_s2_) * (step_s * static_cast<T>(1.0 / kForceMean_s));
  const Vector2 measured_acceleration = measured_h_m_s2
                                            ? core::rotate<T>(*measured_h_m_s2 - tilt_acceleration_h_m_s2_, yaw)
                                            : disturbance_acceleration_w_m_s2_;
  const Vector2 push(median(estimated_m_s2.x(), measured_acceleration.x(), disturbance_acceleration_w_m_s2_.x()),
                     median(estimated_m_s2.y(), measured_acceleration.y(), disturbance_acceleration_w_m_s2_.y()));
  velocity_w_m_s_ += (core::rotate<T>(tilted_h, yaw) + push) * step_s;
  velocity_w_m_s_ = velocity_w_m_s_.cwiseMax(T(-kMax_m_s)).cwiseMin(T(kMax_m_s));
  if (pilots && seen_m_s.squaredNorm() < static_cast<T>(kHovers_m_s * kHovers_m_s)) {
    velocity_w_m_s_ -= velocity_w_m_s_ * (step_s * static_cast<T>(1.0 / kHoverMemory_s));
  } else if (trusted) {
    const bool is_observed = attitude_age_s_ <= static_cast<T>(kGap_s) && step_s <= static_cast<T>(kGap_s);
    const T share = is_observed ? step_s * static_cast<T>(1.0 / kMemory_s) : T(1);
    velocity_w_m_s_ += (seen_m_s - velocity_w_m_s_) * share;
    heading_rad_ = core::wrap_pi(heading_rad_ + core::wrap_pi(estimate.yaw_rad - heading_rad_) * share);
  }
  if (trusted) {
    const T share = step_s / (seen_s_ > static_cast<T>(kFirstMean_s) ? seen_s_ : static_cast<T>(kFirstMean_s));
    disturbance_acceleration_w_m_s2_ += (push - disturbance_acceleration_w_m_s2_) * share;
    offset_rad_ += (Vector2(estimate.x.input_offset_rad, estimate.y.input_offset_rad) - offset_rad_) * share;
  }
}

template <typename T>
Estimate<T> DeadReckoning<T>::replace_motion(const Estimate<T>& estimate) const {
  Estimate<T> known = estimate;
  known.yaw_rad = heading_rad_;
  const Vector2 tilt_rad = core::rotate_by_yaw<T>({estimate.x.tilt_rad, -estimate.y.tilt_rad},
                                                  core::wrap_pi(heading_rad_ - estimate.yaw_rad));
  known.x.tilt_rad = tilt_rad.x();
  known.y.tilt_rad = -tilt_rad.y();
  const auto replace = [this](AxisEstimate<T>& axis, Eigen::Index i) {
    axis.velocity_m_s = velocity_w_m_s_[i];
    axis.disturbance_m_s2 = disturbance_acceleration_w_m_s2_[i];
    axis.input_offset_rad = offset_rad_[i];
    axis.velocity_variance_m2_s2 = static_cast<T>(kVariance_m2_s2);
  };
  replace(known.x, 0);
  replace(known.y, 1);
  return known;
}

template class DeadReckoning<float>;
template class DeadReckoning<double>;

}  // namespace m100::est
