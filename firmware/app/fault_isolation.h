// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>

#include "firmware/est/consistency/attitude_rate_consistency.h"
#include "firmware/est/consistency/command_consistency.h"
#include "firmware/est/consistency/dead_reckoning.h"
#include "firmware/est/consistency/height_consistency.h"
#include "firmware/est/consistency/velocity_consistency.h"
#include "firmware/est/consistency_status.h"
#include "firmware/est/estimate.h"
#include "firmware/est/filter/model_velocity.h"
#include "firmware/est/measurement.h"
#include "firmware/safety/failsafe.h"
#include "firmware/safety/limits.h"

namespace m100::app {

/// Detects false poses and a false attitude, and then supplies another motion for braking.
///
/// The observer's motion counts as false while a check contradicts poses or attitude. While the failsafe ends the
/// flight (kLevel, kRelease) it also does if the attitude is missing, or if poses are refused or return after a gap and
/// the observer's velocity differs from the dead-reckoned one. In these two states it stays false once it was found so.
///
/// Braking then uses the dead-reckoned motion. If the attitude is contradicted or missing, it uses a motion from the
/// poses and from the tilt that the commands predict. If the dead-reckoned speed exceeds what a braking aircraft can
/// reach, no velocity is used: only trim and wind are compensated.
///
/// No heap. Cost: that of its parts. T is float or double.
template <typename T>
class FaultIsolation {
 public:
  /// @param off checks that the operator has switched off.
  explicit FaultIsolation(est::CheckSet off) : disabled_checks_(off), velocity_consistency_(off) {}

  /// Once per tick, after the observer. @param measured only its pose is used. @param model_tilt_rad the tilt that the
  /// model predicts from the commands. @param failsafe_state that of the tick before.
  void update(const est::ImuSample<T>& imu, const est::Measurement<T>& measured, const est::Estimate<T>& estimate,
              const core::Vector<T, 2>& model_tilt_rad, safety::FailsafeState failsafe_state, core::Duration elapsed);

  /// Whether the poses are neither suspected, contradicted nor refused.
  bool trusts_poses() const { return trust_ == Trust::kFull; }
  /// As DeadReckoning::subtract_input_offset.
  void subtract_input_offset(const core::Vector<T, 2>& rad) { dead_reckoning_.subtract_input_offset(rad); }
  bool is_converged() const { return velocity_consistency_.is_converged(); }
  /// See VelocityConsistency.
  T force_scale_m_s2() const { return velocity_consistency_.force_scale_m_s2(); }
  /// See HeadingConsistency::turned_alone_rad.
  T heading_turned_alone_rad() const { return velocity_consistency_.heading_turned_alone_rad(); }
  /// Whether the attitude is contradicted by its rates or by our commands, or is missing while the failsafe ends the
  /// flight. Once true, it stays true for as long as the failsafe ends the flight.
  bool attitude_is_contradicted() const { return trust_ == Trust::kAttitudeFalse; }
  bool poses_read_high() const { return uses(est::ConsistencyCheck::kHeight) && height_consistency_.reads_high(); }
  /// The present contradiction. A false attitude is reported first, because it makes the poses look false, too.
  est::Contradiction<T> contradiction() const;
  /// The disturbance acceleration that the specific force shows and the tilt does not explain, for the observer.
  const est::DisturbanceAcceleration<T>& disturbance_acceleration() const {
    return velocity_consistency_.disturbance_acceleration();
  }
  /// The motion for braking: the estimate, or its replacement while the estimate counts as false.
  est::Estimate<T> motion(const est::Estimate<T>& estimate) const;
  /// The motion by which the fence is held; nullopt: the estimate's. While force or path disagree with the poses, even
  /// before the alarm, the velocity is dead-reckoned, and unseen_m_ is added to the position. The drift of the height
  /// that HeightConsistency finds is subtracted.
  std::optional<est::Estimate<T>> fence_motion(const est::Estimate<T>& estimate) const;
  /// The horizontal speed; zero if there is no usable one, so that nothing waits for the aircraft to slow down.
  double speed_m_s(const est::Estimate<T>& estimate) const;
  /// The horizontal speed after `later`, if tilt and disturbance stay as they are; not less than speed_m_s().
  double speed_then_m_s(const est::Estimate<T>& estimate, core::Duration later) const;
  /// The supervisor's input. refused_for is at least limits.gate_shut while the observer's motion counts as false.
  /// @param levels_limit_cycle true: both speeds are given as 0, because nothing reduces them and the hand-over must
  ///   not wait.
  est::ConsistencyStatus status(const est::Estimate<T>& estimate, safety::FailsafeState failsafe_state,
                                bool levels_limit_cycle, const safety::Limits& limits) const;

 private:
  /// What counts as true, in this order:
  ///
  ///   kFull <-> kDoubted --> kMotionFalse --> kAttitudeFalse
  ///
  /// Each tick decides anew, but while the failsafe ends the flight nothing leads back from the two on the right.
  enum class Trust : std::uint8_t {
    kFull,
    kDoubted,        ///< poses are refused, or a check suspects them; they are used
    kMotionFalse,    ///< braking uses the dead-reckoned motion
    kAttitudeFalse,  ///< braking uses a motion from the poses and from the tilt that the commands predict
  };

  bool is_false() const { return trust_ >= Trust::kMotionFalse; }
  void update_trust(bool motion_is_false, bool attitude_lost, bool refuses, bool settles);
  /// Asked only while something else doubts the motion: an aircraft that swings answers unlike its model, too.
  bool contradicts_command() const {
    return trust_ != Trust::kFull && uses(est::ConsistencyCheck::kAnswer) && command_consistency_.contradicts_command();
  }
  void update_unseen(const core::Vector<T, 2>& apart_m);
  bool poses_are_doubtful(const est::Estimate<T>& estimate, bool settles);
  T speed_after_turn(const core::Vector<T, 2>& model_tilt_rad, T speed_m_s) const;
  core::Vector<T, 2> acceleration_of(const core::Vector<T, 2>& tilt_rad) const;
  void predict_from_commands(const est::Measurement<T>& measured, T step_s);
  bool uses(est::ConsistencyCheck check) const { return (disabled_checks_ & set_of(check)) == 0; }
  bool height_contradicts() const { return uses(est::ConsistencyCheck::kHeight) && height_consistency_.contradicts(); }
  bool rates_contradict() const {
    return uses(est::ConsistencyCheck::kRates) && attitude_rate_consistency_.contradicts();
  }

  est::CheckSet disabled_checks_;
  est::VelocityConsistency<T> velocity_consistency_;
  est::AttitudeRateConsistency<T> attitude_rate_consistency_;
  est::CommandConsistency<T> command_consistency_;
  est::HeightConsistency<T> height_consistency_;
  est::DeadReckoning<T> dead_reckoning_;
  Trust trust_ = Trust::kDoubted;
  core::Vector<T, 2> unseen_m_ =
      core::Vector<T, 2>::Zero();  ///< flown since force or path contradict the poses, and not shown by them
  T max_speed_m_s_{0};             ///< limit of the reckoned speed under braking
  bool diverges_ = false;          ///< the reckoned speed has exceeded max_speed_m_s_
  bool misses_poses_ = false;      ///< since the failsafe began to end the flight, poses were missing for a while
  est::ModelVelocity<T> model_velocity_;
  core::Vector<T, 2> model_tilt_rad_ = core::Vector<T, 2>::Zero();  ///< tilt predicted from the commands, with the trim
};

extern template class FaultIsolation<float>;
extern template class FaultIsolation<double>;

}  // namespace m100::app
