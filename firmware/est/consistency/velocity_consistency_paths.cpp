// SPDX-License-Identifier: BSD-3-Clause
// Compares the paths of poses and specific force (PathConsistency), and measures the noise of both.
#include "firmware/core/frames.h"
#include "firmware/core/maths.h"
#include "firmware/est/consistency/velocity_consistency.h"

namespace m100::est {
namespace {

/// Longer without a used pose is a gap: the observer's position is then its own prediction.
constexpr double kUsedLately_s = 0.15;
constexpr double kMaxSigma_m = 0.5;
/// The height filter reports no variance. A jolt of 1 m/s makes at most 0.23 / a of a path, 0.15 m of the slower one,
/// and lasts twice as long as the memory of the uncertainty; the force's own noise in a message is no jolt.
constexpr double kHeightSigma_m = 0.0005, kJolt_s = 0.3, kNoJolt_m_s = 0.01;
/// When no pose comes for kPoseUsed, the observer's motion is its own prediction. Once poses come again they correct it
/// within this time, and the correction is no motion; refused poses are no such gap. The force bridges a path for at
/// most a second: an offset of 0.05 m/s^2 then makes 0.05 / 2 = 2.5 cm, the uncertainty of a new start.
constexpr double kGapRecovery_s = 0.3;
constexpr core::Duration kBridged = std::chrono::seconds(1);
constexpr double kNoiseMemory_s = 3.0;
constexpr double kTiltMean_s = 1.0;  // the high-pass of a path forgets a longer lean

}  // namespace

/// @returns whether the observer's velocity is its own prediction, or is being corrected by the first poses after a gap
template <typename T>
bool VelocityConsistency<T>::recovers_from_gap(const Estimate<T>& estimate, T step_s) {
  const bool unseen = estimate.pose_age > kPoseUsed && estimate.refused_poses == 0;
  gap_recovery_s_ = unseen                     ? static_cast<T>(kGapRecovery_s)
                    : gap_recovery_s_ > step_s ? gap_recovery_s_ - step_s
                                               : T(0);
  if (unseen && estimate.pose_age > kBridged) {
    restart_paths();
  }
  return gap_recovery_s_ > T(0);
}

/// Starts once the offset of the force has been learned for a second. It uses the same force as kForce and is switched
/// off with it. The two paths take turns, which halves the cost.
template <typename T>
void VelocityConsistency<T>::update_paths(const ImuSample<T>& imu, const Estimate<T>& estimate,
                                          const core::SinCos<T>& yaw, T step_s) {
  const bool used = estimate.refused_poses == 0 && core::seconds<T>(estimate.pose_age) < last_age_s_ + T(0.5) * step_s;
  last_age_s_ = core::seconds<T>(estimate.pose_age);
  estimate_noise(imu, estimate, used, step_s);
  unused_s_ = used ? T(0) : core::clamp(unused_s_ + step_s, T(0), T(1));
  if ((disabled_checks_ & (set_of(ConsistencyCheck::kMotion) | set_of(ConsistencyCheck::kForce))) != 0 ||
      force_seen_s_ < static_cast<T>(kBegins_s)) {
    restart_paths();
    return;
  }
  const bool pose_used = unused_s_ < static_cast<T>(kUsedLately_s);
  const Vector2 force_w_m_s2 = core::rotate<T>(force_h_m_s2_ + accelerometer_bias_h_m_s2(), yaw);
  const T rises = vertical_acceleration_m_s2();
  vertical_turn_ = !vertical_turn_;
  if (vertical_turn_) {
    update_vertical_path(estimate, T(0.5) * (rises + vertical_before_m_s2_), pose_used, T(2) * step_s);
  } else {
    update_horizontal_path(estimate, (force_w_m_s2 + force_before_w_m_s2_) * T(0.5), pose_used, T(2) * step_s);
  }
  force_before_w_m_s2_ = force_w_m_s2;
  vertical_before_m_s2_ = rises;
  const bool contradicts = path_statistic() >= T(1);
  if (contradicts && report_.check == ConsistencyCheck::kNone) {
    const bool upwards = horizontal_path_.evidence() < vertical_path_.evidence();
    report_ = {.check = ConsistencyCheck::kMotion,
               .measured = upwards ? vertical_path_.residual_m() : horizontal_path_.residual_m(),
               .allowed = upwards ? vertical_path_.allowed_m() : horizontal_path_.allowed_m()};
  } else if (!contradicts && report_.check == ConsistencyCheck::kMotion) {
    report_ = {};
  }
}

template <typename T>
void VelocityConsistency<T>::Noise::add(const core::Vector<T, 3>& now, T weight, T share) {
  const core::Vector<T, 3> apart = now - before;
  before = now;
  core::low_pass(level, T(0.25) * apart.template head<2>().squaredNorm() * weight, share);
  core::low_pass(up, T(0.5) * apart.z() * apart.z() * weight, share);
}

/// Measures the noise of the force and of the poses: noise above the assumed values widens the bounds, noise below them
/// changes nothing. Per tick, at any rate of the poses.
template <typename T>
void VelocityConsistency<T>::estimate_noise(const ImuSample<T>& imu, const Estimate<T>& estimate, bool used, T step_s) {
  const T known_s = core::clamp(force_seen_s_, T(0.3), static_cast<T>(kNoiseMemory_s));
  force_age_s_ += step_s;
  if (imu.force_is_new) {
    force_noise_.add({force_h_m_s2_.x(), force_h_m_s2_.y(), lifted_m_s2_}, force_age_s_,
                     core::clamp(force_age_s_ / known_s, T(0), T(1)));
    force_age_s_ = T(0);
  }
  const core::Vector<T, 3> position_m(estimate.x.position_m, estimate.y.position_m, estimate.height_m);
  since_correction_s_ = core::clamp(since_correction_s_ + step_s, T(0), T(1));
  if (used) {
    const core::Vector<T, 3> flown_m_s(estimate.x.velocity_m_s, estimate.y.velocity_m_s, estimate.climb_m_s);
    position_noise_.add(position_m - position_w_m_ - flown_m_s * step_s, step_s / since_correction_s_,
                        core::clamp(since_correction_s_ / known_s, T(0), T(1)));
    since_correction_s_ = T(0);
  }
  position_w_m_ = position_m;
}

/// A blow between two messages of the force changes the climb speed and is missing from the force; the autopilot's own
/// climb speed shows it.
template <typename T>
void VelocityConsistency<T>::update_jolt(const ImuSample<T>& imu, T step_s) {
  measured_gain_m_s_ += vertical_acceleration_m_s2() * step_s;
  if (imu.climb_is_new) {
    const T unmeasured_m_s = imu.climb_m_s - measured_climb_m_s_ - measured_gain_m_s_;
    const T jolt_m_s = core::abs(unmeasured_m_s) - static_cast<T>(kNoJolt_m_s);
    jolt_m_s_ = jolt_m_s > jolt_m_s_ ? jolt_m_s : jolt_m_s_;
    measured_climb_m_s_ = imu.climb_m_s;
    measured_gain_m_s_ = T(0);
  }
}

template <typename T>
void VelocityConsistency<T>::update_horizontal_path(const Estimate<T>& estimate, const Vector2& force_w_m_s2,
                                                    bool pose_used, T step_s) {
  horizontal_path_.update(
      {.force_m_s2 = force_w_m_s2,
       .position_m = Vector2(estimate.x.position_m, estimate.y.position_m),
       .speed_m_s = velocity_w_m_s_,
       // Without the corrections by poses (CovarianceInflation): a sensor fault would excuse itself by its own effect.
       .position_sigma_m = core::sqrt(core::clamp(estimate.x.filter_variance_m2, estimate.y.filter_variance_m2,
                                                  static_cast<T>(kMaxSigma_m * kMaxSigma_m))),
       .position_noise_m2 = position_noise_.level,
       .force_noise_m2_s3 = force_noise_.level},
      pose_used, step_s);
}

/// A hover moves more vertically than horizontally (the climb wanders by 5 cm/s in the measured logs), so a body that
/// stands still shows here first.
template <typename T>
void VelocityConsistency<T>::update_vertical_path(const Estimate<T>& estimate, T vertical_acceleration_m_s2,
                                                  bool pose_used, T step_s) {
  using Vector1 = core::Vector<T, 1>;
  // An aircraft that tilts against a gust stands still and turns the offsets of x and y upward.
  const Vector2 tilt_change_h_m_s2 = tilt_acceleration_h_m_s2_ - mean_tilt_acceleration_h_m_s2_;
  mean_tilt_acceleration_h_m_s2_ += tilt_change_h_m_s2 * (step_s * static_cast<T>(1.0 / kTiltMean_s));
  vertical_path_.update({.force_m_s2 = Vector1(vertical_acceleration_m_s2),
                         .position_m = Vector1(estimate.height_m),
                         .speed_m_s = Vector1(estimate.climb_m_s),
                         .position_sigma_m = static_cast<T>(kHeightSigma_m) + static_cast<T>(kJolt_s) * jolt_m_s_,
                         .position_noise_m2 = position_noise_.up,
                         .force_noise_m2_s3 = force_noise_.up,
                         .tilt_acceleration_m2_s4 = tilt_change_h_m_s2.squaredNorm()},
                        pose_used, step_s);
  jolt_m_s_ = T(0);
}

template <typename T>
T VelocityConsistency<T>::path_statistic() const {
  return horizontal_path_.evidence() < vertical_path_.evidence() ? vertical_path_.evidence()
                                                                 : horizontal_path_.evidence();
}

#define M100_PATHS_OF(T)                                                                                              \
  template void VelocityConsistency<T>::update_paths(const ImuSample<T>&, const Estimate<T>&, const core::SinCos<T>&, \
                                                     T);                                                              \
  template void VelocityConsistency<T>::update_vertical_path(const Estimate<T>&, T, bool, T);                         \
  template void VelocityConsistency<T>::update_horizontal_path(const Estimate<T>&, const Vector2&, bool, T);          \
  template void VelocityConsistency<T>::update_jolt(const ImuSample<T>&, T);                                          \
  template void VelocityConsistency<T>::estimate_noise(const ImuSample<T>&, const Estimate<T>&, bool, T);             \
  template void VelocityConsistency<T>::Noise::add(const core::Vector<T, 3>&, T, T);                                  \
  template bool VelocityConsistency<T>::recovers_from_gap(const Estimate<T>&, T);                                     \
  template T VelocityConsistency<T>::path_statistic() const;
M100_PATHS_OF(float)
M100_PATHS_OF(double)
#undef M100_PATHS_OF

}  // namespace m100::est
