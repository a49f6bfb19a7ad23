// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "hal/clock.h"

namespace m100::hal {

/// A clock that advances only when a test, or a call of sleep_until(), advances it.
class ManualClock final : public Clock {
 public:
  core::TimePoint now() override { return now_; }
  /// Advances the time to the deadline, plus the requested stall.
  void sleep_until(core::TimePoint deadline) override {
    now_ = (deadline > now_ ? deadline : now_) + stall_;
    stall_ = core::Duration{0};
  }

  void advance(core::Duration step) { now_ += step; }
  /// Makes the next sleep too long by `stall`, as a busy machine does.
  void stall_next_sleep(core::Duration stall) { stall_ = stall; }

 private:
  core::TimePoint now_{};
  core::Duration stall_{0};
};

}  // namespace m100::hal
