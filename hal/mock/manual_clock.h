// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "hal/clock.h"

namespace m100::hal {

/// A clock that advances only when a test, or a call of sleep_until(), advances it.
class ManualClock final : public Clock {
 public:
  core::TimePoint now() override { return now_; }
  void sleep_until(core::TimePoint deadline) override { now_ = deadline > now_ ? deadline : now_; }

  void advance(core::Duration step) { now_ += step; }

 private:
  core::TimePoint now_{};
};

}  // namespace m100::hal
