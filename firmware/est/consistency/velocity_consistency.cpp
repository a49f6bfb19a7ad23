// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/est/consistency/velocity_consistency.h"

#include "firmware/core/frames.h"

namespace m100::est {
namespace {

/// After a longer tick, or a longer time without a new force, the motion was not observed. The last force, held this
/// long while the true one is 4 m/s^2 off, errs by 0.2 m/s.
constexpr core::Duration kGap = std::chrono::milliseconds(50);
constexpr double kSane = 1e9;

}  // namespace

/// Runs without a pose, too, because then the observer's prediction needs the disturbance.
template <typename T>
void VelocityConsistency<T>::update_disturbance(const core::SinCos<T>& yaw, bool is_known, T step_s) {
  const T averages = disturbance_acceleration_.is_known ? step_s * static_cast<T>(1.0 / kForceMean_s) : T(1);
  disturbance_acceleration_.is_known = is_known;
  disturbance_acceleration_.now_w_m_s2 =
      core::rotate<T>(specific_force_.acceleration_h_m_s2() - specific_force_.tilt_acceleration_h_m_s2(), yaw);
  disturbance_acceleration_.mean_w_m_s2 +=
      (disturbance_acceleration_.now_w_m_s2 - disturbance_acceleration_.mean_w_m_s2) * averages;
}

/// The first contradiction is reported until the check that found it no longer contradicts.
template <typename T>
void VelocityConsistency<T>::report_if(bool contradicts, const Contradiction<T>& found) {
  if (contradicts && report_.check == ConsistencyCheck::kNone) {
    report_ = found;
  } else if (!contradicts && report_.check == found.check) {
    report_ = {};
  }
}

template <typename T>
void VelocityConsistency<T>::judge(ConsistencyCheck check, CheckEvidence<T>& evidence, T step_s) {
  if (is_disabled(check)) {
    return;
  }
  evidence.add(step_s);
  report_if(evidence.cusum.exceeds_threshold(),
            {.check = check, .measured = evidence.residual, .allowed = evidence.allowed});
}

/// Whether all sums are finite: one that is not would never raise an alarm again.
template <typename T>
bool VelocityConsistency<T>::is_sane() const {
  const T all = specific_force_.magnitude() + force_.magnitude() + heading_.magnitude() + paths_.magnitude() +
                disturbance_acceleration_.mean_w_m_s2.squaredNorm();
  return all < static_cast<T>(kSane);
}

template <typename T>
[[gnu::cold]] void VelocityConsistency<T>::reset_sums() {
  specific_force_.reset();
  force_.reset();
  heading_.reset();
  paths_.reset();
  disturbance_acceleration_ = {};
}

template <typename T>
void VelocityConsistency<T>::update_force(const ImuSample<T>& imu, const Estimate<T>& estimate,
                                          core::Duration elapsed) {
  force_age_ = imu.force_is_new ? core::Duration{0} : core::clamp(force_age_ + elapsed, core::Duration{0}, 2 * kGap);
  if (imu.force_is_new) {
    specific_force_.update(imu);
  }
  is_observed_ = elapsed <= kGap && (force_age_ <= kGap || !specific_force_.is_received());
  const bool force_counts = force_scale_m_s2() > T(0) && !is_disabled(ConsistencyCheck::kForce) &&
                            specific_force_.learned_s() >= static_cast<T>(ForceConsistency<T>::kFirstLook_s);
  update_disturbance(estimate.heading(), force_counts && estimate.prediction_valid && is_observed_,
                     core::seconds<T>(elapsed));
}

template <typename T>
void VelocityConsistency<T>::update(const ImuSample<T>& imu, const Estimate<T>& estimate,
                                    const core::Vector<T, 2>& disturbance_acceleration_w_m_s2, core::Duration elapsed) {
  if (!is_sane()) {
    reset_sums();
  }
  const T step_s = core::seconds<T>(elapsed);
  const bool force_disabled = is_disabled(ConsistencyCheck::kForce);
  update_force(imu, estimate, elapsed);
  if (!estimate.healthy) {
    force_.lose_estimate();
  }
  if (!estimate.healthy || !is_observed_) {
    force_.restart();
    suspect_ = false;
    paths_.restart();
    if (is_observed_) {
      specific_force_.average(specific_force_.acceleration_h_m_s2(), step_s);
    }
    return;
  }
  if (paths_.recovers_from_gap(estimate, step_s)) {
    force_.restart();  // the sum continues from the corrected velocity
  }
  force_.update(estimate, specific_force_, paths_.vibration(), disturbance_acceleration_w_m_s2, suspect_, step_s);
  suspect_ = !force_disabled && force_.exceeds_allowed();
  if (paths_.update(imu, estimate, specific_force_, force_, force_disabled || is_disabled(ConsistencyCheck::kMotion),
                    step_s)) {
    report_if(paths_.evidence() >= T(1),
              {.check = ConsistencyCheck::kMotion, .measured = paths_.residual_m(), .allowed = paths_.allowed_m()});
  }
  suspect_ = suspect_ || paths_.evidence() > T(0.5);
  heading_.update(imu, estimate, step_s);
  if (estimate.pose_age > PathMonitor<T>::kPoseUsed) {
    return;
  }
  judge(ConsistencyCheck::kForce, force_.evidence(), step_s);
  if (imu.climb_is_new) {
    climb_.update(imu, estimate, paths_.climb_error_m_s(), paths_.climb_noise_m2_s2());
    judge(ConsistencyCheck::kClimb, climb_.evidence(), step_s);
  }
  if (imu.attitude_is_new) {
    judge(ConsistencyCheck::kHeading, heading_.evidence(), step_s);
  }
}

template class VelocityConsistency<float>;
template class VelocityConsistency<double>;

}  // namespace m100::est
