// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "firmware/core/pose.h"
#include "firmware/core/time.h"
#include "firmware/est/timing/clock_shift.h"

namespace m100::est {

/// Converts seconds to a Duration; exact to the microsecond up to 8 s in float.
template <typename T>
core::Duration duration_of(T seconds) {
  return core::Duration(static_cast<core::Duration::rep>(seconds * T(1e6) + (seconds < T(0) ? T(-0.5) : T(0.5))));
}

/// Estimates a quantile of numbers that come one by one.
class Quantile {
 public:
  /// @param share of the numbers below the quantile
  /// @param step_s largest change by one number
  constexpr Quantile(float share, float step_s) : share_(share), step_s_(step_s) {}
  void update(float value_s) { value_s_ += value_s > value_s_ ? share_ * step_s_ : (share_ - 1.F) * step_s_; }
  /// Restarts from a value after the measured quantity has changed.
  void set(float value_s) { value_s_ = value_s; }
  float value_s() const { return value_s_ > 0.F ? value_s_ : 0.F; }

 private:
  float share_;
  float step_s_;
  float value_s_ = 0.F;
};

/// Removes transport jitter from the times of capture of a source that stamps its captures with a clock of its own.
///
/// With s the sender's time of a capture and y the time at which the pose came,
///   y = t0 + r s + delta,  delta >= 0,
/// because a message can be late but never early. Least squares over some 3000 poses give the rate r. t0 + r s is the
/// lower envelope of y: it falls at once to a smaller y and rises slowly. The constant latency of all messages remains;
/// PoseLatency finds it. If the sender's clock was set or slewed, t0 is estimated anew and the rate is kept.
/// Time stamps that have once followed the arrivals stay trusted: a pose that then comes far later than its stamp says
/// is old, however long that lasts.
///
/// Cost: about 30 products, some ten divisions and a square root a pose, ClockShift included. In float for every
/// scalar: the arithmetic uses only time differences, taken in whole microseconds, never times of a whole flight.
class PoseClock {
 public:
  /// What is known of a pose besides its times.
  struct Context {
    bool clock_was_set = false;  ///< concluded from the order of the stamps, which doubled poses also disturb
    std::uint32_t poses = 1;     ///< number that came since the call before
  };
  /// @param captured if it is not later than in the previous call, the sender's clock was set
  /// @returns our time of capture plus the constant latency: when the pose would have arrived without jitter. It is
  ///   `arrived` itself before 30 poses have come (counted again after 10 s without one), for a pose that shows that
  ///   the clock was set, and while the sender's time stamps do not follow the arrivals.
  core::TimePoint update(core::SenderTime captured, core::TimePoint arrived, const Context& context);
  core::TimePoint update(core::SenderTime captured, core::TimePoint arrived) {
    return update(captured, arrived, Context{});
  }

  /// Time between two captures of the source; zero until it is known.
  core::Duration interval() const;
  /// How much faster our clock runs than the sender's, as a ratio; zero until it is known.
  float drift() const { return count_ < kMinPoses ? 0.F : drift_; }
  /// 99th percentile of the jitter that update() removes.
  core::Duration lateness() const;
  /// By how much the sender's clock was set or slewed since the beginning, in sum (positive: forward), and how often.
  core::Duration set_by() const { return set_by_; }
  std::uint32_t times_set() const { return times_set_; }
  /// How much later poses come, for an unknown reason: the clock was set back, or their transport takes longer.
  core::Duration unexplained() const { return duration_of(shift_.unexplained_s()); }
  /// Corrects the estimate for the time that the sender's clock has lost, which makes poses look late.
  void lose(core::Duration lost);
  /// Whether update() removes jitter.
  bool is_regular() const { return count_ >= kMinPoses && (is_proven() || lateness_.value_s() < kMaxLateness_s); }

 private:
  static constexpr std::uint32_t kMinPoses = 30;
  static constexpr std::uint32_t kProven = 20;  ///< poses in a row, after the first kMinPoses
  static constexpr float kMaxLateness_s = 0.12F;
  bool is_proven() const { return in_time_ >= kProven; }
  void begin(core::SenderTime captured, core::TimePoint arrived);
  void fit();
  void update_interval(float step_s);
  bool was_set(core::Duration step, core::Duration gap, const Context& context) const;
  void restart(core::SenderTime captured, core::TimePoint arrived);
  void note_shift(const ClockShift::Step& step);
  void set(core::Duration by);

  core::TimePoint last_arrived_{};
  core::SenderTime last_{};
  std::uint32_t count_ = 0;
  std::uint32_t in_time_ = 0;    ///< poses in a row not far later than their stamps; stays at kProven
  float spacing_s_ = 0.F;        ///< between two captures
  float min_long_step_s_ = 0.F;  ///< shortest in the present row of unusually long steps
  std::uint32_t long_steps_ = 0;
  // Least squares with forgetting: (y - s) over s, each about its running mean; s and y as in the class comment.
  float own_s_ = 0.F;
  float slipped_s_ = 0.F;
  float square_ = 0.F;
  float product_ = 0.F;
  float drift_ = 0.F;     ///< r - 1
  float behind_s_ = 0.F;  ///< how long the last pose arrived after the envelope
  Quantile lateness_{0.99F, 1e-3F};
  ClockShift shift_;
  core::Duration set_by_{0};
  std::uint32_t times_set_ = 0;
};

}  // namespace m100::est
