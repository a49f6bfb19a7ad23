// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "hal/clock.h"

namespace m100::hal {

/// CLOCK_MONOTONIC, counted from the construction of this object.
class MonotonicClock final : public Clock {
 public:
  MonotonicClock();
  core::TimePoint now() override;
  void sleep_until(core::TimePoint deadline) override;

 private:
  core::Duration start_;  ///< of CLOCK_MONOTONIC
};

}  // namespace m100::hal
