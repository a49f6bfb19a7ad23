// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/app/fault_isolation.h"

#include "firmware/core/maths.h"
#include "firmware/model/vehicle.h"

namespace m100::app {

namespace {

/// After braking begins, the tilt takes a quarter of a second to reverse. Until then the speed may grow by the tilt of
/// our commands or by the measured force, whichever gives more, and in a gust by kGust_m_s.
constexpr double kTurnsRound_s = 0.25, kGust_m_s = 0.4;
constexpr double kFar_m_s = 0.5;  ///< doubtful poses are false if observed and dead-reckoned velocity differ by more

}  // namespace

template <typename T>
est::Contradiction<T> FaultIsolation<T>::contradiction() const {
  if (rates_contradict()) {
    return {.check = est::ConsistencyCheck::kRates,
            .measured = attitude_rate_consistency_.residual_rad(),
            .allowed = attitude_rate_consistency_.allowed_rad()};
  }
  if (contradicts_command()) {
    return {.check = est::ConsistencyCheck::kAnswer,
            .measured = command_consistency_.residual_rad(),
            .allowed = command_consistency_.allowed_rad()};
  }
  if (velocity_consistency_.report().check == est::ConsistencyCheck::kNone && height_contradicts()) {
    return {.check = est::ConsistencyCheck::kHeight,
            .measured = height_consistency_.drift_m(),
            .allowed = height_consistency_.allowed_m()};
  }
  return velocity_consistency_.report();
}

template <typename T>
void FaultIsolation<T>::update(const est::ImuSample<T>& imu, const est::Measurement<T>& measured,
                               const est::Estimate<T>& estimate, const core::Vector<T, 2>& model_tilt_rad,
                               safety::FailsafeState failsafe_state, core::Duration elapsed) {
  attitude_rate_consistency_.update(imu, core::seconds<T>(elapsed));
  model_tilt_rad_ = model_tilt_rad + dead_reckoning_.offset_rad();
  predict_from_commands(measured, core::seconds<T>(elapsed));
  command_consistency_.update(model_velocity_.velocity_w_m_s() - dead_reckoning_.velocity_w_m_s(),
                              {.commanded_m_s2 = acceleration_of(model_tilt_rad_),
                               .reported_m_s2 = acceleration_of({estimate.x.tilt_rad, estimate.y.tilt_rad})},
                              model_velocity_.follows_poses(), failsafe_state != safety::FailsafeState::kSilent,
                              core::seconds<T>(elapsed));
  height_consistency_.update(imu, estimate, failsafe_state != safety::FailsafeState::kSilent,
                             core::seconds<T>(elapsed));
  velocity_consistency_.update(imu, estimate, dead_reckoning_.disturbance_acceleration_w_m_s2(), elapsed);
  const bool contradicted = contradiction().check != est::ConsistencyCheck::kNone;
  const core::Vector<T, 2> apart =
      core::Vector<T, 2>(estimate.x.velocity_m_s, estimate.y.velocity_m_s) - dead_reckoning_.velocity_w_m_s();
  const bool settles =
      failsafe_state == safety::FailsafeState::kLevel || failsafe_state == safety::FailsafeState::kRelease;
  const bool refused =
      poses_are_doubtful(estimate, settles) && apart.squaredNorm() > static_cast<T>(kFar_m_s * kFar_m_s);
  const bool attitude_lost = settles && !estimate.attitude_is_known && model_velocity_.is_known();
  update_trust(contradicted || refused || attitude_lost, attitude_lost, estimate.refused_poses > 0, settles);
  const T speed_m_s = core::sqrt(dead_reckoning_.velocity_w_m_s().squaredNorm());
  if (!is_false()) {
    max_speed_m_s_ = speed_after_turn(model_tilt_rad, speed_m_s) + static_cast<T>(kGust_m_s);
  }
  const bool is_measured = attitude_is_contradicted() && model_velocity_.is_known();
  diverges_ = settles && !is_measured && (speed_m_s > max_speed_m_s_ || diverges_);
  if (attitude_is_contradicted()) {
    dead_reckoning_.set_velocity(model_velocity_.velocity_w_m_s());
  } else {
    dead_reckoning_.update(imu, estimate, velocity_consistency_.measured_h_m_s2(), trusts_poses(),
                           failsafe_state == safety::FailsafeState::kSilent, elapsed);
  }
  update_unseen(apart * core::seconds<T>(elapsed));
}

/// The commands can accuse the attitude only once the motion is known to be false, so they are asked last.
template <typename T>
void FaultIsolation<T>::update_trust(bool motion_is_false, bool attitude_lost, bool refuses, bool settles) {
  const bool was_false = settles && is_false(), accused = settles && attitude_is_contradicted();
  trust_ = motion_is_false || was_false                    ? Trust::kMotionFalse
           : refuses || velocity_consistency_.is_suspect() ? Trust::kDoubted
                                                           : Trust::kFull;
  if (rates_contradict() || contradicts_command() || attitude_lost || accused) {
    trust_ = Trust::kAttitudeFalse;
  }
}

template <typename T>
void FaultIsolation<T>::update_unseen(const core::Vector<T, 2>& apart_m) {
  if (velocity_consistency_.is_suspect() || is_false()) {
    unseen_m_ -= apart_m;
  } else {
    unseen_m_.setZero();
  }
}

/// Whether poses are refused, or come again after a gap, while the failsafe ends the flight.
template <typename T>
bool FaultIsolation<T>::poses_are_doubtful(const est::Estimate<T>& estimate, bool settles) {
  const bool missed = estimate.pose_age > est::PathMonitor<T>::kPoseUsed;
  misses_poses_ = settles && (misses_poses_ || missed);
  return settles && (estimate.refused_poses > 0 || (misses_poses_ && !missed));
}

template <typename T>
T FaultIsolation<T>::speed_after_turn(const core::Vector<T, 2>& model_tilt_rad, T speed_m_s) const {
  constexpr T kGain_m_s = static_cast<T>(kTurnsRound_s * model::kGravity_m_s2);
  const core::Vector<T, 2> tilted_m_s(kGain_m_s * model_tilt_rad.x(), -kGain_m_s * model_tilt_rad.y());
  const T moved_m_s = speed_m_s + static_cast<T>(kTurnsRound_s) * velocity_consistency_.moved_m_s2();
  const T turned_m_s = core::sqrt((dead_reckoning_.velocity_w_m_s() + tilted_m_s).squaredNorm());
  return moved_m_s > turned_m_s ? moved_m_s : turned_m_s;
}

/// The acceleration in the world by a tilt and the wind; m/s^2.
template <typename T>
core::Vector<T, 2> FaultIsolation<T>::acceleration_of(const core::Vector<T, 2>& tilt_rad) const {
  constexpr T kGravity_m_s2 = static_cast<T>(model::kGravity_m_s2);
  return core::Vector<T, 2>(kGravity_m_s2 * core::tan(tilt_rad.x()), -kGravity_m_s2 * core::tan(tilt_rad.y())) +
         dead_reckoning_.disturbance_acceleration_w_m_s2();
}

/// Updates the model velocity. It is predicted from the tilt that the commands give, not from the reported attitude,
/// and corrected by new poses.
template <typename T>
void FaultIsolation<T>::predict_from_commands(const est::Measurement<T>& measured, T step_s) {
  model_velocity_.predict(acceleration_of(model_tilt_rad_), step_s);
  if (measured.pose.is_new) {
    model_velocity_.fuse(measured.pose.position_w_m.template head<2>(),
                         core::seconds<T>(measured.pose.age(measured.now)));
  }
}

template <typename T>
est::Estimate<T> FaultIsolation<T>::motion(const est::Estimate<T>& estimate) const {
  constexpr T kNotToBeUsed_m2_s2 = T(1e6);
  est::Estimate<T> known = is_false() ? dead_reckoning_.replace_motion(estimate) : estimate;
  if (attitude_is_contradicted()) {
    known.prediction_valid = known.prediction_valid || model_velocity_.is_known();
    known.x.tilt_rad = model_tilt_rad_.x();
    known.y.tilt_rad = model_tilt_rad_.y();
  }
  if (diverges_) {
    known.x.velocity_variance_m2_s2 = known.y.velocity_variance_m2_s2 = kNotToBeUsed_m2_s2;
  }
  return known;
}

template <typename T>
std::optional<est::Estimate<T>> FaultIsolation<T>::fence_motion(const est::Estimate<T>& estimate) const {
  const bool suspect = velocity_consistency_.is_suspect() || is_false();
  const T drift_m = uses(est::ConsistencyCheck::kHeight) ? height_consistency_.unexplained_drift_m() : T(0);
  if (!suspect && drift_m == T(0)) {  // then nothing was flown unseen
    return {};
  }
  est::Estimate<T> known = suspect ? dead_reckoning_.replace_motion(estimate) : estimate;
  known.x.position_m += unseen_m_.x();
  known.y.position_m += unseen_m_.y();
  known.height_m -= drift_m;
  return known;
}

template <typename T>
double FaultIsolation<T>::speed_m_s(const est::Estimate<T>& estimate) const {
  constexpr T kWorthless_m2_s2 = T(1);
  const est::AxisEstimate<T>& x = estimate.x;
  const est::AxisEstimate<T>& y = estimate.y;
  const bool learned =
      is_false() || (x.velocity_variance_m2_s2 < kWorthless_m2_s2 && y.velocity_variance_m2_s2 < kWorthless_m2_s2);
  if (!(estimate.prediction_valid || attitude_is_contradicted()) || diverges_ || !learned) {
    return 0.0;
  }
  const core::Vector<T, 2> velocity_m_s =
      is_false() ? dead_reckoning_.velocity_w_m_s() : core::Vector<T, 2>(x.velocity_m_s, y.velocity_m_s);
  return static_cast<double>(core::sqrt(velocity_m_s.squaredNorm()));
}

template <typename T>
double FaultIsolation<T>::speed_then_m_s(const est::Estimate<T>& estimate, core::Duration later) const {
  constexpr T kGravity_m_s2 = static_cast<T>(model::kGravity_m_s2);
  const double now_m_s = speed_m_s(estimate);
  const est::Estimate<T> known = motion(estimate);
  const core::Vector<T, 2> velocity_m_s(known.x.velocity_m_s, known.y.velocity_m_s);
  const core::Vector<T, 2> disturbance_acceleration_m_s2(known.x.disturbance_m_s2 + kGravity_m_s2 * known.x.tilt_rad,
                                                         known.y.disturbance_m_s2 - kGravity_m_s2 * known.y.tilt_rad);
  const bool grows =
      now_m_s > 0.0 && velocity_m_s.dot(disturbance_acceleration_m_s2) > T(0);  // zero: no usable speed is known
  return grows ? static_cast<double>(
                     core::sqrt((velocity_m_s + disturbance_acceleration_m_s2 * core::seconds<T>(later)).squaredNorm()))
               : now_m_s;
}

template <typename T>
est::ConsistencyStatus FaultIsolation<T>::status(const est::Estimate<T>& estimate, safety::FailsafeState failsafe_state,
                                                 bool levels_limit_cycle, const safety::Limits& limits) const {
  const est::Contradiction<T> contradicted = contradiction();
  const core::Vector<T, 2> lever_b_m = velocity_consistency_.lever_arm().lever_b_m();
  const bool predicts = !levels_limit_cycle && failsafe_state == safety::FailsafeState::kLevel;
  return {
      .refused_poses = estimate.refused_poses,
      .refused_for = is_false() && estimate.refused_for < limits.gate_shut ? limits.gate_shut : estimate.refused_for,
      .refused_by_m = static_cast<double>(estimate.refusal.distance_m),
      .refused_allowed_m = static_cast<double>(estimate.refusal.allowed_m),
      .refused_turn_rad = static_cast<double>(estimate.refusal.turned_rad),
      .speed_m_s = levels_limit_cycle ? 0.0 : speed_m_s(estimate),
      .speed_then_m_s = predicts ? speed_then_m_s(estimate, limits.neutral) : 0.0,
      .contradicted_by = static_cast<std::uint8_t>(contradicted.check),
      .contradicted_with = static_cast<double>(contradicted.measured),
      .contradicted_allowed = static_cast<double>(contradicted.allowed),
      .vibration =
          velocity_consistency_.vibration().status(static_cast<T>(est::ForceConsistency<T>::kVelocityMemory_s)),
      .lever_b_m = {static_cast<double>(lever_b_m.x()), static_cast<double>(lever_b_m.y()), 0.0}};
}

template class FaultIsolation<float>;
template class FaultIsolation<double>;

}  // namespace m100::app
