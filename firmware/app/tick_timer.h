// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "firmware/core/assert.h"
#include "firmware/core/time.h"

namespace m100::app {

struct TickStats {
  std::uint32_t ticks = 0;
  std::uint32_t stalls = 0;  ///< more than two periods since the last tick (R9); the failsafe sees the old pose
  core::Duration longest{0};
};

/// How much time each tick covers.
class TickTimer {
 public:
  static constexpr core::Duration kStall = 2 * core::kTickPeriod;  ///< promise R9

  /// Precondition (asserted): `now` is not before the last one; otherwise ages in the program would be negative.
  void update(core::TimePoint now) {
    M100_ASSERT(stats_.ticks == 0 || now >= last_);
    elapsed_ = stats_.ticks == 0 ? core::kTickPeriod : now - last_;
    stats_.stalls += is_stall() ? 1U : 0U;
    stats_.longest = elapsed_ > stats_.longest ? elapsed_ : stats_.longest;
    stats_.ticks += 1;
    last_ = now;
  }

  /// Since the tick before; one period in the first tick.
  core::Duration elapsed() const { return elapsed_; }
  bool is_stall() const { return elapsed_ > kStall; }
  core::TimePoint last() const { return last_; }
  const TickStats& stats() const { return stats_; }

 private:
  core::TimePoint last_{};
  core::Duration elapsed_ = core::kTickPeriod;
  TickStats stats_;
};

}  // namespace m100::app
