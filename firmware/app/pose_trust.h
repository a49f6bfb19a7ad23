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

/// Reacts to false poses: compares the poses with the autopilot, remembers that they gave the observer a false motion,
/// and then supplies another motion for braking.
///
/// Contradicted poses have given the observer a false motion. Poses that the gate refuses may have done so if the
/// observer's motion is far from the one that is computed without them. The observer's motion then counts as false
/// until the ladder has ended. If the autopilot's attitude and rates contradict each other, or the attitude does not
/// follow our commands while pose and force disagree, the attitude is false, and the motion is computed from the tilt
/// predicted by the commands. If the computed speed grows although the aircraft brakes, it is useless: the aircraft is
/// levelled by trim and wind, without waiting for it to slow down.
///
/// No heap. Cost: that of its four parts. T is float or double.
template <typename T>
class PoseTrust {
 public:
  /// @param off checks that the operator has switched off.
  explicit PoseTrust(est::CheckSet off) : off_(off), cross_check_(off) {}

  /// Once per tick, after the observer. @param measured its pose. @param asked_rad the tilt that the model predicts
  /// from the commands. @param rung of the ladder before this tick's review.
  void update(const est::Felt<T>& felt, const est::Measurement<T>& measured, const est::Estimate<T>& estimate,
              const core::Vector<T, 2>& asked_rad, safety::Rung rung, core::Duration elapsed);

  bool has_looked() const { return cross_check_.has_looked(); }
  /// The present contradiction. A false attitude is reported first, because it makes the poses look false, too.
  est::Contradiction<T> contradiction() const;
  /// The push that the specific force shows and the tilt does not explain, for the observer.
  const est::Push<T>& push() const { return cross_check_.push(); }
  /// The motion for braking: a contradicted estimate would follow the false poses.
  est::Estimate<T> motion(const est::Estimate<T>& estimate) const;
  /// Horizontal. Zero if the prediction is useless, so that nothing waits for the aircraft to slow down.
  double speed_m_s(const est::Estimate<T>& estimate) const;
  /// The same after `later`, if tilt and push stay as they are; not less than now.
  double speed_then_m_s(const est::Estimate<T>& estimate, core::Duration later) const;
  /// Adds refused and contradicted poses to the observation; a contradicted one counts as refused for long.
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
  T most_m_s_{0};            ///< limit of the reckoned speed under braking
  bool tilt_lies_ = false;   ///< the attitude is contradicted: by its rates, or by our own commands
  bool runs_away_ = false;   ///< the reckoned motion is useless
  bool poses_side_ = false;  ///< the poses are where the commands lead, and far from where the attitude does
  core::Vector<T, 2> seen_apart_m_ = core::Vector<T, 2>::Zero();  ///< from the observer's place to the poses, mean
  core::Vector<T, 2> asked_m_s_ = core::Vector<T, 2>::Zero();     ///< velocity from this tilt, without the poses
  core::Vector<T, 2> asked_rad_ = core::Vector<T, 2>::Zero();     ///< tilt predicted from the commands, with the trim
};

extern template class PoseTrust<float>;
extern template class PoseTrust<double>;

}  // namespace m100::app
