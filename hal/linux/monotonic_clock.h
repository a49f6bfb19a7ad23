// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "hal/clock.h"
#include "hal/linux/system_calls.h"

namespace m100::hal {

/// CLOCK_MONOTONIC, counted from the construction of this object.
class MonotonicClock final : public Clock {
 public:
  explicit MonotonicClock(const SystemCalls& calls = real_system_calls());
  core::TimePoint now() override;
  void sleep_until(core::TimePoint deadline) override;

 private:
  const SystemCalls* calls_;
  core::Duration start_;  ///< of CLOCK_MONOTONIC
};

}  // namespace m100::hal
