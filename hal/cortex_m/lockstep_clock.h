// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "hal/clock.h"
#include "hal/cortex_m/cmsdk_uart.h"
#include "hal/cortex_m/lockstep_message.h"

namespace m100::hal {

/// The clock of an emulated board: the peer sends the time (lockstep_message.h).
class LockstepClock final : public Clock {
 public:
  LockstepClock(CmsdkUart& control, const CmsdkUart& autopilot, const CmsdkUart& pose)
      : control_(control), autopilot_(autopilot), pose_(pose) {}

  core::TimePoint now() override { return now_; }
  /// Waits for the peer's next step, whatever the deadline, and for the bytes that the step announces.
  void sleep_until(core::TimePoint deadline) override;

  LockstepOrder order() const { return order_; }
  void report(std::uint32_t tick_cycles, std::uint32_t stack_bytes);

 private:
  CmsdkUart& control_;
  const CmsdkUart& autopilot_;
  const CmsdkUart& pose_;
  core::TimePoint now_{};
  LockstepOrder order_ = LockstepOrder::kNone;
};

}  // namespace m100::hal
