// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/ctl/law/flight_law.h"
#include "firmware/ctl/monitor/limit_cycle_detector.h"
#include "firmware/ctl/monitor/limit_cycle_status.h"

namespace m100::ctl {

/// Reacts to a limit cycle: the fallback law flies from the tick after its detection until the law stops flying. If
/// the oscillation persists after kFades_s, the failsafe is informed. T is float or double.
template <typename T>
class LimitCycleResponse {
 public:
  static constexpr double kFades_s = 2.0;

  /// @param braking of the vehicle; gives the fallback law's bandwidth. @param enabled false: no reaction (for tests).
  LimitCycleResponse(const Braking& braking, bool enabled)
      : rate_per_s_(fallback_rate_per_s<T>(braking)), enabled_(enabled) {}

  /// Once per tick, after the law. @param flies whether the law flies; @param excited whether a plan moves a stick.
  void update(const est::Estimate<T>& estimate, const ref::Window<T>& window, bool flies, bool excited, T step_s,
              FlightLaw<T>& law) {
    detector_.update(estimate, window, flies && !excited, step_s);
    const LimitCycleReport<T> now = detector_.report();
    seen_ = now.detected ? now : flies ? seen_ : LimitCycleReport<T>{};
    goes_on_ = now.detected && law.fallback();
    if (now.detected && !law.fallback() && enabled_) {
      law.start_fallback(rate_per_s_);
      detector_.pause(static_cast<T>(kFades_s));
    }
    fallback_ = law.fallback();
  }

  /// The last limit cycle that was detected since the law began to fly.
  const LimitCycleReport<T>& seen() const { return seen_; }
  /// The aircraft oscillates in this tick although the fallback law flies.
  bool persists() const { return goes_on_; }
  LimitCycleStatus status() const {
    return {.height_rad = static_cast<double>(seen_.height_rad),
            .frequency_hz = static_cast<double>(seen_.frequency_hz),
            .detected = fallback_,
            .persists = goes_on_};
  }

 private:
  LimitCycleDetector<T> detector_;
  LimitCycleReport<T> seen_;
  T rate_per_s_;
  bool enabled_;
  bool goes_on_ = false;
  bool fallback_ = false;  ///< the law flies its fallback
};

}  // namespace m100::ctl
