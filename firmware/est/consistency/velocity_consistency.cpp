// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/est/consistency/velocity_consistency.h"

#include "firmware/core/frames.h"
#include "firmware/core/maths.h"
#include "firmware/core/tilt.h"
#include "firmware/model/vehicle.h"

namespace m100::est {
namespace {

/// Each bound is the largest error that a healthy flight may have for an unlimited time.
///
/// force: at most 0.34 m/s: a time of capture that is wrong by 80 ms (the largest in the worlds that ship) times the
///   largest acceleration of the law, 4.3 m/s^2 at 25 degrees of tilt. In smaller motions less is allowed: see
///   allowed_m_s().
/// climb: the same 80 ms while the aircraft starts its climb at 2.5 m/s^2; the observer's climb speed is wrong by
///   0.03 m/s.
/// heading: 100 ms at the largest yaw rate, 1.75 rad/s, and 2 degrees of the compass besides its slow drift, which the
///   mean removes; the noise of a pose's heading is 0.002 rad.
constexpr double kMaxForceError_m_s = 0.35, kMaxClimbError_m_s = 0.2, kMaxHeadingError_rad = 0.21;

/// Memory of the sum of velocity: a part of the force's offset that is not yet known, 0.2 m/s^2 (measured logs: a few
/// tenths), must not fill the sum for longer than a manoeuvre lasts.
constexpr double kVelocityMemory_s = 2.0;
/// The offset is constant over a flight, the tilt's error varies within seconds: ten times the memory of the velocity.
constexpr double kOffsetMemory_s = 20.0;
/// In the first 3 s the offset is not yet well known. Its uncertainty, 0.15 m/s at first, is allowed in addition.
constexpr double kFirstLook_s = 3.0;
constexpr double kFirstLook_m_s = 0.15;
/// While the check doubts, at most this much is learned as an offset: the rest may be the effect of a sensor fault.
constexpr double kMaxOffset_m_s2 = 0.5;
constexpr double kHeadingMemory_s = 5.0;  ///< the compass drifts more slowly; a turn of the aircraft is over sooner
/// After a longer tick the motion was not observed: the sum restarts from the next velocity.
constexpr core::Duration kGap = std::chrono::milliseconds(50);
/// A flight within 35 degrees of tilt measures 1 to 1.22 g in the mean; climb and gusts vary it.
constexpr double kMin_g = 0.8, kMax_g = 1.4;
/// Larger than any sensor's range, in g or in m/s^2: such a force is ignored, because its square may overflow in single
/// precision.
constexpr double kMaxForce = 400.0;
constexpr double kSane = 1e9;

/// Difference to the force that is allowed for an unlimited time, in m/s, as a sum of
///   calm   three sigmas of the observer's velocity in calm air, 0.03 m/s, and beyond them what a start in wind left
///          (start_sigma_m_s_); the rotors' 0.1 m/s^2 at 100 Hz add 0.1 sqrt(0.01 s x 2 s / 2) = 0.01 m/s to the sum
///   moves  a time of capture that is wrong by 80 ms, times the acceleration of the last second
///   wind   the observer learns a push in 0.15 s; gusts change the push of a wind by a third of it
/// An alarm needs twice that for half a second, six sigmas of the noise; the campaign tests what no noise describes
/// (README).
constexpr double kCalm_m_s = 0.1, kMoves_s = 0.08, kWind_s = 0.05, kSigmas = 3.0;
constexpr double kMaxStartSigma_m_s = 10.0;
constexpr double kMovedLately_s = 1.0;

template <typename T>
T size_of(T value) {
  return value < T(0) ? -value : value;
}

}  // namespace

/// Turns the newest specific force into horizontal axes at the aircraft's heading.
template <typename T>
void VelocityConsistency<T>::update_specific_force(const ImuSample<T>& imu) {
  const core::Vector<T, 3>& f = imu.force_b;
  if (!(f.squaredNorm() < static_cast<T>(kMaxForce * kMaxForce))) {
    return;
  }
  const T size = core::sqrt(f.squaredNorm());
  force_size_ += (size - force_size_) * (force_size_ > T(0) ? T(0.01) : T(1));
  const auto about = [this](double unit) {
    return force_size_ > static_cast<T>(kMin_g * unit) && force_size_ < static_cast<T>(kMax_g * unit);
  };
  const T scale = about(1.0) ? static_cast<T>(model::kGravity_m_s2) : about(model::kGravity_m_s2) ? T(1) : T(0);
  force_scale_m_s2_ = scale;
  if (scale == T(0)) {
    force_seen_s_ = T(0);
    return;
  }
  const core::SinCos<T>& roll = imu.roll();
  const core::SinCos<T>& pitch = imu.pitch();
  const T upright = roll.sine * f.y() + roll.cosine * f.z();
  force_h_m_s2_ = Vector2(pitch.cosine * f.x() + pitch.sine * upright, roll.cosine * f.y() - roll.sine * f.z()) * scale;
  lifted_m_s2_ = (pitch.cosine * upright - pitch.sine * f.x()) * scale - static_cast<T>(model::kGravity_m_s2);
  tilt_acceleration_h_m_s2_ = core::heading_slope_of(roll, pitch) * static_cast<T>(model::kGravity_m_s2);
}

template <typename T>
T VelocityConsistency<T>::allowed_m_s(const Vector2& disturbance_acceleration_w_m_s2) const {
  const T disturbance_m_s2 = core::sqrt(disturbance_acceleration_w_m_s2.squaredNorm());
  const T allowed =
      static_cast<T>(kCalm_m_s) + static_cast<T>(kMoves_s) * moved_m_s2_ + static_cast<T>(kWind_s) * disturbance_m_s2;
  const T most = static_cast<T>(kMaxForceError_m_s);
  const T unknown = core::clamp(
      (static_cast<T>(kFirstLook_s) - force_seen_s_) * static_cast<T>(1.0 / (kFirstLook_s - kBegins_s)), T(0), T(1));
  return (allowed < most ? allowed : most) + unknown * static_cast<T>(kFirstLook_m_s) +
         static_cast<T>(kSigmas) * start_sigma_m_s_;
}

/// A start in wind leaves the observer uncertain for some seconds, and it reports that. Only what has been left over
/// since the start counts: later a sensor fault would excuse itself by its own effect on the reported sigma.
template <typename T>
void VelocityConsistency<T>::update_start_sigma(const Estimate<T>& estimate) {
  const T variance_m2_s2 = core::clamp(estimate.x.velocity_variance_m2_s2 + estimate.y.velocity_variance_m2_s2, T(0),
                                       static_cast<T>(kMaxStartSigma_m_s * kMaxStartSigma_m_s));
  const T sigma_m_s = core::sqrt(variance_m2_s2) - static_cast<T>(kCalm_m_s / kSigmas);
  start_sigma_m_s_ = core::clamp(sigma_m_s, T(0), start_sigma_m_s_);
}

/// The offset is fixed to the body: an aircraft that leans turns a part of the z offset into the horizontal, and a turn
/// of the heading in wind turns that part relative to the wind.
/// @returns the total horizontal offset, forward and left
template <typename T>
typename VelocityConsistency<T>::Vector2 VelocityConsistency<T>::accelerometer_bias_h_m_s2() const {
  return offset_h_m_s2_ + tilt_acceleration_h_m_s2_ * (offset_up_m_s2_ * static_cast<T>(1.0 / model::kGravity_m_s2));
}

/// Measured upward acceleration, without gravity.
template <typename T>
T VelocityConsistency<T>::vertical_acceleration_m_s2() const {
  const T across_m_s2 = offset_h_m_s2_.dot(tilt_acceleration_h_m_s2_) * static_cast<T>(1.0 / model::kGravity_m_s2);
  return lifted_m_s2_ + offset_up_m_s2_ - across_m_s2;
}

/// Learns the offset of the body's z: in the mean the upward force is gravity plus the change of climb speed, and
/// vertical_acceleration_m_s2() subtracts the part of the other two offsets. To first order in the tilt: the second
/// order, at 20 degrees, is 6 % of an offset.
template <typename T>
void VelocityConsistency<T>::estimate_vertical_bias(T climbed_m_s, T most_m_s, T share, T step_s) {
  const T unmeasured_m_s = climbed_m_s - vertical_acceleration_m_s2() * step_s;
  offset_up_m_s2_ += core::clamp(unmeasured_m_s, -most_m_s, most_m_s) * share;
}

/// Runs without a pose, too, because the prediction then needs it.
template <typename T>
void VelocityConsistency<T>::update_disturbance(const core::SinCos<T>& yaw, bool is_known, T step_s) {
  const T averages = disturbance_acceleration_.is_known ? step_s * static_cast<T>(1.0 / kForceMean_s) : T(1);
  disturbance_acceleration_.is_known = is_known;
  disturbance_acceleration_.now_w_m_s2 =
      core::rotate<T>(force_h_m_s2_ + accelerometer_bias_h_m_s2() - tilt_acceleration_h_m_s2_, yaw);
  disturbance_acceleration_.mean_w_m_s2 +=
      (disturbance_acceleration_.now_w_m_s2 - disturbance_acceleration_.mean_w_m_s2) * averages;
}

/// @returns the recent change of horizontal velocity that the pose shows and the force does not
template <typename T>
T VelocityConsistency<T>::velocity_residual(const Estimate<T>& estimate, const core::SinCos<T>& yaw, T step_s) {
  const Vector2 velocity(estimate.x.velocity_m_s, estimate.y.velocity_m_s);
  const Vector2 step_w = velocity - velocity_w_m_s_;
  velocity_w_m_s_ = velocity;
  const T climbed_m_s = estimate.climb_m_s - climb_m_s_;
  climb_m_s_ = estimate.climb_m_s;
  if (force_size_ == T(0) || !velocity_known_) {
    velocity_known_ = true;
    return T(0);
  }
  const Vector2 step_h = core::rotate<T>(step_w, {.sine = -yaw.sine, .cosine = yaw.cosine});
  const Vector2 measured_h_m_s2 = force_h_m_s2_ + accelerometer_bias_h_m_s2();
  const Vector2 unmeasured_h = step_h - measured_h_m_s2 * step_s;
  force_seen_s_ = core::clamp(force_seen_s_ + step_s, T(0), static_cast<T>(kOffsetMemory_s));
  const T most = suspect_ ? static_cast<T>(kMaxOffset_m_s2) * step_s : T(1);
  const Vector2 learned_h = unmeasured_h.cwiseMax(-most).cwiseMin(most);
  const T share = T(1) / (force_seen_s_ > T(1) ? force_seen_s_ : T(1));
  const Vector2 corrected_h = learned_h * share;
  estimate_vertical_bias(climbed_m_s, most, share, step_s);
  offset_h_m_s2_ += corrected_h;
  measured_h_m_s2_ +=
      (measured_h_m_s2 + corrected_h - measured_h_m_s2_) * (step_s * static_cast<T>(1.0 / kForceMean_s));
  const T moves_m_s2 = core::sqrt(measured_h_m_s2_.squaredNorm());
  moved_m_s2_ -= moved_m_s2_ * (step_s * static_cast<T>(1.0 / kMovedLately_s));
  moved_m_s2_ = moves_m_s2 > moved_m_s2_ ? moves_m_s2 : moved_m_s2_;
  if (force_seen_s_ < static_cast<T>(kBegins_s)) {
    velocity_residual_w_m_s_.setZero();
    summed_s_ = T(0);
    return T(0);
  }
  // The sum uses the offset as it is known now, not as it was known while the sum was accumulated.
  const T fades = step_s * static_cast<T>(1.0 / kVelocityMemory_s);
  summed_s_ += step_s - summed_s_ * fades;
  velocity_residual_w_m_s_ += core::rotate<T>(unmeasured_h - corrected_h * (suspect_ ? T(0) : summed_s_), yaw) -
                              velocity_residual_w_m_s_ * fades;
  return core::sqrt(velocity_residual_w_m_s_.squaredNorm());
}

template <typename T>
T VelocityConsistency<T>::heading_residual(const ImuSample<T>& imu, const Estimate<T>& estimate, T step_s) {
  const T difference_rad = core::wrap_pi(estimate.yaw_rad - imu.yaw_rad);
  heading_offset_rad_ = heading_known_ ? heading_offset_rad_ : difference_rad;
  heading_known_ = true;
  const T turned_rad = core::wrap_pi(difference_rad - heading_offset_rad_);
  heading_offset_rad_ =
      core::wrap_pi(heading_offset_rad_ + turned_rad * (step_s * static_cast<T>(1.0 / kHeadingMemory_s)));
  return size_of(turned_rad);
}

template <typename T>
void VelocityConsistency<T>::accumulate(ConsistencyCheck check, T disagreement, T allowed, T step_s) {
  if ((disabled_checks_ & set_of(check)) != 0) {
    return;
  }
  Cusum<T>& evidence = cusum_[static_cast<std::size_t>(check)];
  evidence.add(disagreement, allowed, step_s);
  if (evidence.exceeds_threshold() && report_.check == ConsistencyCheck::kNone) {
    report_ = {.check = check, .measured = disagreement, .allowed = allowed};
  } else if (!evidence.exceeds_threshold() && report_.check == check) {
    report_ = {};
  }
}

/// A sum that is not finite would never raise an alarm again.
template <typename T>
bool VelocityConsistency<T>::is_sane() const {
  const T all = velocity_residual_w_m_s_.squaredNorm() + offset_h_m_s2_.squaredNorm() + measured_h_m_s2_.squaredNorm() +
                size_of(offset_up_m_s2_) + size_of(heading_offset_rad_) + moved_m_s2_ + force_size_ +
                disturbance_acceleration_.mean_w_m_s2.squaredNorm() + force_noise_.level + force_noise_.up +
                position_noise_.level + position_noise_.up + jolt_m_s_ + mean_tilt_acceleration_h_m_s2_.squaredNorm();
  return all < static_cast<T>(kSane);
}

template <typename T>
[[gnu::cold]] void VelocityConsistency<T>::reset_sums() {
  velocity_residual_w_m_s_.setZero();
  offset_h_m_s2_.setZero();
  measured_h_m_s2_.setZero();
  mean_tilt_acceleration_h_m_s2_.setZero();
  offset_up_m_s2_ = moved_m_s2_ = force_size_ = force_seen_s_ = summed_s_ = jolt_m_s_ = measured_gain_m_s_ = T(0);
  velocity_known_ = heading_known_ = false;
  disturbance_acceleration_ = {};
  force_noise_ = position_noise_ = {};
  restart_paths();
}

template <typename T>
void VelocityConsistency<T>::update(const ImuSample<T>& imu, const Estimate<T>& estimate,
                                    const Vector2& disturbance_acceleration_w_m_s2, core::Duration elapsed) {
  if (!is_sane()) {
    reset_sums();
  }
  if (imu.force_is_new) {
    update_specific_force(imu);
  }
  const T step_s = core::seconds<T>(elapsed);
  const core::SinCos<T>& yaw = estimate.heading();
  const bool force_counts = force_scale_m_s2_ > T(0) &&
                            force_seen_s_ >= static_cast<T>(kFirstLook_s) &&  // its offset is known
                            (disabled_checks_ & set_of(ConsistencyCheck::kForce)) == 0;
  update_disturbance(yaw, force_counts && estimate.prediction_valid && elapsed <= kGap, step_s);
  start_sigma_m_s_ = estimate.healthy ? start_sigma_m_s_ : static_cast<T>(kMaxStartSigma_m_s);
  if (!estimate.healthy || elapsed > kGap) {
    velocity_known_ = false;
    suspect_ = false;
    restart_paths();
    return;
  }
  if (recovers_from_gap(estimate, step_s)) {
    velocity_known_ = false;  // the sum continues from the corrected velocity
  }
  const T velocity_residual_m_s = velocity_residual(estimate, yaw, step_s);
  update_start_sigma(estimate);
  update_jolt(imu, step_s);
  const T allowed = allowed_m_s(disturbance_acceleration_w_m_s2);
  suspect_ = (disabled_checks_ & set_of(ConsistencyCheck::kForce)) == 0 && velocity_residual_m_s > allowed;
  update_paths(imu, estimate, yaw, step_s);
  suspect_ = suspect_ || path_statistic() > T(0.5);
  const T turned_rad = imu.attitude_is_new ? heading_residual(imu, estimate, step_s) : T(0);
  if (estimate.pose_age > kPoseUsed) {
    return;
  }
  accumulate(ConsistencyCheck::kForce, velocity_residual_m_s, allowed, step_s);
  if (imu.climb_is_new) {
    accumulate(ConsistencyCheck::kClimb, size_of(estimate.climb_m_s - imu.climb_m_s),
               static_cast<T>(kMaxClimbError_m_s), step_s);
  }
  if (imu.attitude_is_new) {
    accumulate(ConsistencyCheck::kHeading, turned_rad, static_cast<T>(kMaxHeadingError_rad), step_s);
  }
}

template class VelocityConsistency<float>;
template class VelocityConsistency<double>;

}  // namespace m100::est
