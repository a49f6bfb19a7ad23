// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <string_view>
#include <utility>

#include "firmware/core/time.h"

namespace m100::sim {

/// The autopilot's own 400 Hz clock. It runs fast or slow against ours, in which all times are given.
class N1Clock {
 public:
  static constexpr core::Duration kTick = std::chrono::microseconds(2500);

  /// @param drift_ppm positive: it runs fast
  explicit N1Clock(double drift_ppm) : drift_ppm_(drift_ppm) {}
  core::TimePoint now() const { return now_; }
  core::TimePoint next() const { return time_of(ticks_ + 1); }
  std::uint32_t ticks_since_boot() const { return static_cast<std::uint32_t>(ticks_ - booted_at_tick_); }
  /// @returns the time that the tick took.
  core::Duration tick() {
    const core::TimePoint before = std::exchange(now_, next());
    ++ticks_;
    return now_ - before;
  }
  void restart() { booted_at_tick_ = ticks_; }

 private:
  core::TimePoint time_of(std::int64_t tick) const {
    const double own_us = static_cast<double>(tick * kTick.count());
    return core::TimePoint(core::Duration(std::llround(own_us / (1.0 + 1e-6 * drift_ppm_))));
  }

  double drift_ppm_;
  core::TimePoint now_{};
  std::int64_t ticks_ = 0;
  std::int64_t booted_at_tick_ = 0;
};

/// One event. Names are those of the protocol's catalogue if there is one.
struct N1Event {
  core::TimePoint at{};
  std::string_view
      what;  ///< "received", "answered", "ignored", "did"; a breach is "received", with a "violation_" name
  std::string_view name;
  double value = 0.0;
};

/// Sends the events of the emulated autopilot to a function, each with the time of the tick.
class N1EventLog {
 public:
  explicit N1EventLog(const N1Clock& clock) : clock_(clock) {}
  void set_sink(std::function<void(const N1Event&)> sink) { sink_ = std::move(sink); }
  void emit(std::string_view what, std::string_view name, double value = 0.0) const {
    if (sink_) {
      sink_({.at = now(), .what = what, .name = name, .value = value});
    }
  }
  core::TimePoint now() const { return clock_.now(); }

 private:
  const N1Clock& clock_;
  std::function<void(const N1Event&)> sink_;
};

}  // namespace m100::sim
