// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "hal/watchdog.h"

namespace m100::hal {

/// Registers of the Arm CMSDK APB watchdog, without its lock register, which has a separate address.
struct CmsdkWatchdogRegisters {
  volatile std::uint32_t load;             ///< counts down from here, in cycles of the peripheral clock
  volatile std::uint32_t value;            ///< the remaining cycles
  volatile std::uint32_t control;          ///< bit 0: count, and interrupt at 0; bit 1: reset at the second 0
  volatile std::uint32_t interrupt_clear;  ///< any value: clears the interrupt and counts from load again
};

/// The watchdog of an MPS2 board. Its interrupt is the NMI, which nothing masks.
class CmsdkWatchdog final : public Watchdog {
 public:
  CmsdkWatchdog(CmsdkWatchdogRegisters& registers, volatile std::uint32_t& lock, std::uint32_t clock_hz)
      : registers_(registers), lock_(lock), clock_hz_(clock_hz) {}

  void start(core::Duration patience) override;
  void feed() override;

 private:
  CmsdkWatchdogRegisters& registers_;
  volatile std::uint32_t& lock_;
  std::uint32_t clock_hz_;
};

}  // namespace m100::hal
