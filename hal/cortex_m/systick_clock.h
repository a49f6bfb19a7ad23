// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstdint>

#include "hal/clock.h"

namespace m100::hal {

/// Registers of the Cortex-M system timer, which counts down from `reload` to 0 and restarts.
struct SysTickRegisters {
  volatile std::uint32_t control;  ///< bit 0: on, bit 1: interrupt at 0, bit 2: counts the processor's clock
  volatile std::uint32_t reload;
  volatile std::uint32_t value;  ///< any write sets it to 0
  volatile std::uint32_t calibration;
};

/// Time from the system timer: whole periods are counted in its interrupt, the rest is read from its counter.
class SysTickClock final : public Clock {
 public:
  SysTickClock(SysTickRegisters& registers, std::uint32_t clock_hz, std::uint32_t period_us);

  void start();
  core::TimePoint now() override;
  /// Polls, because an emulator that sleeps in wfi receives fifty times slower, and a board has nothing else to do.
  void sleep_until(core::TimePoint deadline) override;

  /// Processor cycles since start(). Under QEMU's -icount shift=0 at 25 MHz, forty instructions are one cycle.
  std::uint64_t cycles() const;

  /// Interrupt handler.
  void on_period() { periods_.store(periods_.load(std::memory_order_relaxed) + 1, std::memory_order_release); }

 private:
  SysTickRegisters& registers_;
  std::uint32_t cycles_per_us_;
  std::uint32_t cycles_per_period_;
  std::atomic<std::uint32_t> periods_{0};  // wraps after 497 days of 10 ms
};

}  // namespace m100::hal
