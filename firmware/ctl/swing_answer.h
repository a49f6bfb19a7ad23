// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/ctl/flight_law.h"
#include "firmware/ctl/swing_watch.h"

namespace m100::ctl {

/// Reacts to a swing: the calm law flies from the tick in which the swing is noticed until the law stops flying. If the
/// swing still goes on after kFades_s, the ladder is told. T is float or double.
template <typename T>
class SwingAnswer {
 public:
  static constexpr double kFades_s = 2.0;

  /// @param braking of the vehicle; gives the calm law's rate. @param answers false: no reaction (for tests).
  SwingAnswer(const Braking& braking, bool answers) : rate_per_s_(calm_rate_per_s<T>(braking)), answers_(answers) {}

  /// Once per tick, after the law. @param flies whether the law flies; @param excited whether a plan moves a stick.
  void update(const est::Estimate<T>& estimate, const ref::Window<T>& window, bool flies, bool excited, T step_s,
              FlightLaw<T>& law) {
    watch_.update(estimate, window, flies && !excited, step_s);
    const SwingReport<T> now = watch_.report();
    seen_ = now.swings ? now : flies ? seen_ : SwingReport<T>{};
    goes_on_ = now.swings && law.calm();
    if (now.swings && !law.calm() && answers_) {
      law.calm_down(rate_per_s_);
      watch_.pause(static_cast<T>(kFades_s));
    }
  }

  /// The last swing that was noticed in this flight.
  const SwingReport<T>& seen() const { return seen_; }
  /// The aircraft swings in this tick although the calm law flies.
  bool goes_on() const { return goes_on_; }

 private:
  SwingWatch<T> watch_;
  SwingReport<T> seen_;
  T rate_per_s_;
  bool answers_;
  bool goes_on_ = false;
};

}  // namespace m100::ctl
