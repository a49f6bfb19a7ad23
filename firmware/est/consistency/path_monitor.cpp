// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/est/consistency/path_monitor.h"

#include "firmware/core/frames.h"
#include "firmware/core/maths.h"

namespace m100::est {
namespace {

/// Without a used pose for longer, the path has a gap: the observer's position is then its own prediction.
constexpr double kUsedLately_s = 0.15;
/// An error dv of the velocity leaves dv (t - a t^2 / 2) exp(-a t) in the slow path, a = 0.75 1/s: below dv / (a e).
constexpr double kPathOfVelocity_s = 0.49;
constexpr double kMaxSigma_m = 0.5;
/// Sigma of the height, beside the 2 mm that the scales of PathConsistency include for the observer's error.
constexpr double kHeightSigma_m = 0.0005, kIncludedSigma_m = 0.002;
/// A jolt of 1 m/s makes a path of at most 0.23 / a, 0.15 m at the slower scale; kJolt_s is twice that.
constexpr double kJolt_s = 0.3, kNoJolt_m_s = 0.01;
/// In a climb above kHover_m_s the climb's gain is known to 30 %. The observer's height is then wrong by the error of
/// its climb speed times kHeightLag_s.
constexpr double kClimbGain = 0.3, kHover_m_s = 0.2, kHeightLag_s = 0.08, kClimbMemory_s = 1.0;
/// The first poses after a gap correct the observer within kGapRecovery_s. A gap of kBridged restarts the paths.
/// Refused poses are no gap.
constexpr double kGapRecovery_s = 0.3;
constexpr core::Duration kBridged = std::chrono::seconds(1);
constexpr double kTiltMean_s = 1.0;  // the high-pass of a path forgets a longer lean

template <typename T>
T size(T value) {
  return value < T(0) ? -value : value;
}

}  // namespace

template <typename T>
bool PathMonitor<T>::recovers_from_gap(const Estimate<T>& estimate, T step_s) {
  const bool unseen = estimate.pose_age > kPoseUsed && estimate.refused_poses == 0;
  gap_recovery_s_ = unseen                     ? static_cast<T>(kGapRecovery_s)
                    : gap_recovery_s_ > step_s ? gap_recovery_s_ - step_s
                                               : T(0);
  if (unseen && estimate.pose_age > kBridged) {
    restart();
  }
  return gap_recovery_s_ > T(0);
}

template <typename T>
bool PathMonitor<T>::update(const ImuSample<T>& imu, const Estimate<T>& estimate, const SpecificForce<T>& force,
                            const ForceConsistency<T>& velocity, bool disabled, T step_s) {
  update_climb_error(imu, estimate, step_s);
  update_jolt(imu, force, step_s);
  const bool used = estimate.refused_poses == 0 && core::seconds<T>(estimate.pose_age) < last_age_s_ + T(0.5) * step_s;
  last_age_s_ = core::seconds<T>(estimate.pose_age);
  noise_.update(imu, force, estimate, used, step_s);
  unused_s_ = used ? T(0) : core::clamp(unused_s_ + step_s, T(0), T(1));
  if (disabled || force.learned_s() < static_cast<T>(ForceConsistency<T>::kBegins_s)) {
    restart();
    return false;
  }
  const bool pose_used = unused_s_ < static_cast<T>(kUsedLately_s);
  const Vector2 force_w_m_s2 = core::rotate<T>(force.acceleration_h_m_s2(), estimate.heading());
  const T rises = force.vertical_acceleration_m_s2();
  vertical_turn_ = !vertical_turn_;
  if (vertical_turn_) {
    update_vertical(estimate, force, T(0.5) * (rises + vertical_before_m_s2_), pose_used, T(2) * step_s);
  } else {
    // The smaller of the two yaw rates, so that a sensor fault of one channel cannot widen the bound.
    const T seen_rad_s = size(estimate.yaw_rate_rad_s), gyro_rad_s = size(imu.rate_b_rad_s.z());
    update_horizontal(estimate, velocity, (force_w_m_s2 + force_before_w_m_s2_) * T(0.5),
                      seen_rad_s < gyro_rad_s ? seen_rad_s : gyro_rad_s, pose_used, T(2) * step_s);
  }
  force_before_w_m_s2_ = force_w_m_s2;
  vertical_before_m_s2_ = rises;
  return true;
}

/// The bound uses the smaller of the two climb speeds, so that a sensor fault of one channel cannot widen it.
template <typename T>
void PathMonitor<T>::update_climb_error(const ImuSample<T>& imu, const Estimate<T>& estimate, T step_s) {
  const auto error_m_s = [](T climb_m_s) {
    return static_cast<T>(kClimbGain) * (size(climb_m_s) - static_cast<T>(kHover_m_s));
  };
  const T pose_m_s = error_m_s(estimate.climb_m_s), autopilot_m_s = error_m_s(imu.climb_m_s);
  const T now_m_s = pose_m_s < autopilot_m_s ? pose_m_s : autopilot_m_s;
  climb_error_m_s_ -= climb_error_m_s_ * (step_s * static_cast<T>(1.0 / kClimbMemory_s));
  climb_error_m_s_ = now_m_s > climb_error_m_s_ ? now_m_s : climb_error_m_s_;
}

/// A blow between two messages of the force is missing from the force. The autopilot's climb speed shows it.
template <typename T>
void PathMonitor<T>::update_jolt(const ImuSample<T>& imu, const SpecificForce<T>& force, T step_s) {
  measured_gain_m_s_ += force.vertical_acceleration_m_s2() * step_s;
  if (imu.climb_is_new) {
    const T unmeasured_m_s = imu.climb_m_s - measured_climb_m_s_ - measured_gain_m_s_;
    const T jolt_m_s = size(unmeasured_m_s) - static_cast<T>(kNoJolt_m_s);
    jolt_m_s_ = jolt_m_s > jolt_m_s_ ? jolt_m_s : jolt_m_s_;
    measured_climb_m_s_ = imu.climb_m_s;
    measured_gain_m_s_ = T(0);
  }
}

template <typename T>
void PathMonitor<T>::update_horizontal(const Estimate<T>& estimate, const ForceConsistency<T>& velocity,
                                       const Vector2& force_w_m_s2, T turn_rad_s, bool pose_used, T step_s) {
  horizontal_.update(
      {.force_m_s2 = force_w_m_s2,
       .position_m = Vector2(estimate.x.position_m, estimate.y.position_m),
       .speed_m_s = velocity.velocity_w_m_s(),
       // Without CovarianceInflation: a faulty sensor would raise the inflated variance, and so excuse itself.
       .position_sigma_m = core::sqrt(core::clamp(estimate.x.filter_variance_m2, estimate.y.filter_variance_m2,
                                                  static_cast<T>(kMaxSigma_m * kMaxSigma_m))) +
                           static_cast<T>(kPathOfVelocity_s) * velocity.start_sigma_m_s(),
       .position_noise_m2 = noise_.position_m2().horizontal,
       .force_noise_m2_s3 = vibration().density_m2_s3().horizontal,
       .turn_rad_s = turn_rad_s},
      pose_used, step_s);
  const T new_s = horizontal_.apart_is_new() ? static_cast<T>(PathConsistency<T>::kScales) * step_s : T(0);
  lever_arm_.update(estimate.heading(), horizontal_.apart_m(), static_cast<T>(PathConsistency<T>::kApart_per_s), step_s,
                    new_s);
}

/// A pose that does not move is detected here first: a hover moves more vertically than horizontally.
template <typename T>
void PathMonitor<T>::update_vertical(const Estimate<T>& estimate, const SpecificForce<T>& force,
                                     T vertical_acceleration_m_s2, bool pose_used, T step_s) {
  using Vector1 = core::Vector<T, 1>;
  const T sigma_m = core::sqrt(estimate.pose_height_variance_m2) - static_cast<T>(kIncludedSigma_m);
  // While the aircraft leans against a gust without moving, a part of the offsets of x and y points upward.
  const Vector2 tilt_change_h_m_s2 = force.tilt_acceleration_h_m_s2() - mean_tilt_acceleration_h_m_s2_;
  mean_tilt_acceleration_h_m_s2_ += tilt_change_h_m_s2 * (step_s * static_cast<T>(1.0 / kTiltMean_s));
  vertical_.update(
      {.force_m_s2 = Vector1(vertical_acceleration_m_s2),
       .position_m = Vector1(estimate.height_m),
       .speed_m_s = Vector1(estimate.climb_m_s),
       .position_sigma_m = static_cast<T>(kHeightSigma_m) + (sigma_m > T(0) ? sigma_m : T(0)) +
                           static_cast<T>(kJolt_s) * jolt_m_s_ + static_cast<T>(kHeightLag_s) * climb_error_m_s_,
       .position_noise_m2 = noise_.position_m2().vertical,
       .force_noise_m2_s3 = vibration().density_m2_s3().vertical,
       .tilt_acceleration_m2_s4 = tilt_change_h_m_s2.squaredNorm()},
      pose_used, step_s);
  jolt_m_s_ = T(0);
}

template <typename T>
[[gnu::cold]] void PathMonitor<T>::reset() {
  mean_tilt_acceleration_h_m_s2_.setZero();
  jolt_m_s_ = climb_error_m_s_ = measured_gain_m_s_ = T(0);
  noise_.reset();
  restart();
}

template class PathMonitor<float>;
template class PathMonitor<double>;

}  // namespace m100::est
