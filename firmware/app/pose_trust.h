// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/est/answer_check.h"
#include "firmware/est/cross_check.h"
#include "firmware/est/dead_reckoning.h"
#include "firmware/est/estimate.h"
#include "firmware/est/measurement.h"
#include "firmware/est/tilt_check.h"
#include "firmware/safety/ladder.h"
#include "firmware/safety/observation.h"

namespace m100::app {

/// What answers a pose that lies: holds the poses against the autopilot, remembers that they have taught the observer a
/// false motion, and then knows the motion that is braked instead.
///
/// Poses that are contradicted have taught the observer a false motion; poses that the gate refuses may have, where it
/// is far from the one that is reckoned without them. What was learned stays false until the ladder has ended. Where
/// attitude and rates of the autopilot contradict each other, or the attitude does not answer our commands while pose
/// and force disagree, it is the attitude that lies, and the motion is reckoned from the tilt that the commands make.
/// Where the reckoned speed grows under a braking that takes it away, it is worth nothing: the aircraft is levelled by
/// trim and wind, and nobody waits for it to slow down.
///
/// No heap. Cost: that of its four parts. T is float or double.
template <typename T>
class PoseTrust {
 public:
  /// @param off checks that the operator has switched off.
  explicit PoseTrust(est::CheckSet off) : off_(off), cross_check_(off) {}

  /// Once per tick, after the observer. @param measured its pose. @param asked_rad the tilt that the commands make by
  /// the model. @param rung of the ladder before this tick's review.
  void update(const est::Felt<T>& felt, const est::Measurement<T>& measured, const est::Estimate<T>& estimate,
              const core::Vector<T, 2>& asked_rad, safety::Rung rung, core::Duration elapsed);

  bool has_looked() const { return cross_check_.has_looked(); }
  /// An attitude that is wrong makes the poses seem so too, and is told first.
  est::Contradiction<T> contradiction() const;
  /// What the specific force shows beside the tilt, for the observer.
  const est::Push<T>& push() const { return cross_check_.push(); }
  /// What is braked by: an estimate that is contradicted would fly the lie.
  est::Estimate<T> motion(const est::Estimate<T>& estimate) const;
  /// Horizontal. Of a prediction that is worth nothing, none: nobody waits for it to slow down.
  double speed_m_s(const est::Estimate<T>& estimate) const;
  /// The same so much later, if the aircraft tilts and is pushed as it is; not less than now.
  double speed_then_m_s(const est::Estimate<T>& estimate, core::Duration later) const;
  /// What the supervisor is told of refused and contradicted poses; a contradicted one counts as long refused.
  void tell(safety::Observation& observed, const est::Estimate<T>& estimate, core::Duration gate_shut) const;

 private:
  bool is_unanswered() const;
  void see(const est::Measurement<T>& measured, const est::Estimate<T>& estimate, const core::Vector<T, 2>& asked_rad);
  void reckon_asked(const est::Estimate<T>& estimate, bool trusted, bool pilots, T step_s);
  est::Felt<T> as_asked(const est::Felt<T>& felt, T yaw_rad) const;
  bool rates_contradict() const { return (off_ & set_of(est::Check::kRates)) == 0 && tilt_check_.contradicts(); }

  est::CheckSet off_;
  est::CrossCheck<T> cross_check_;
  est::TiltCheck<T> tilt_check_;
  est::AnswerCheck<T> answer_check_;
  est::DeadReckoning<T> reckoning_;
  bool lied_to_ = false;     ///< the observer's motion was learned from poses that are contradicted
  T most_m_s_{0};            ///< that the reckoned speed may reach under braking
  bool tilt_lies_ = false;   ///< it is the attitude that is contradicted: by its rates, or by our own commands
  bool runs_away_ = false;   ///< the reckoned motion is worth nothing
  bool poses_side_ = false;  ///< the poses are where the commands lead, and far from where the attitude does
  core::Vector<T, 2> seen_apart_m_ = core::Vector<T, 2>::Zero();  ///< from the observer's place to the poses, mean
  core::Vector<T, 2> asked_m_s_ = core::Vector<T, 2>::Zero();     ///< velocity that this tilt makes, beside the poses
  core::Vector<T, 2> asked_rad_ = core::Vector<T, 2>::Zero();     ///< the tilt that the commands make, with the trim
};

extern template class PoseTrust<float>;
extern template class PoseTrust<double>;

}  // namespace m100::app
