// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "hal/cortex_m/cmsdk_uart.h"
#include "hal/cortex_m/cmsdk_watchdog.h"
#include "hal/cortex_m/systick_clock.h"

// Addresses of Arm's MPS2 board with the AN500 image (Cortex-M7), as QEMU emulates it. Another board needs a header
// like this one (linker/PORTING.md).
namespace m100::hal::mps2 {

inline constexpr std::uint32_t kClock_hz = 25000000;

// NOLINTBEGIN(performance-no-int-to-ptr): registers stand at numbers

/// UART 0 to 2. Their interrupts are 2 n (receive) and 2 n + 1 (transmit).
inline CmsdkUartRegisters& uart(std::uint32_t number) {
  return *reinterpret_cast<CmsdkUartRegisters*>(0x40004000U + 0x1000U * number);
}

inline SysTickRegisters& systick() { return *reinterpret_cast<SysTickRegisters*>(0xE000E010U); }

/// The watchdog counts the system clock; its interrupt is the NMI.
inline CmsdkWatchdogRegisters& watchdog() { return *reinterpret_cast<CmsdkWatchdogRegisters*>(0x40008000U); }
inline volatile std::uint32_t& watchdog_lock() { return *reinterpret_cast<volatile std::uint32_t*>(0x40008C00U); }

/// The NVIC's registers for interrupts 0 to 31.
inline volatile std::uint32_t& set_enabled() { return *reinterpret_cast<volatile std::uint32_t*>(0xE000E100U); }
inline volatile std::uint32_t& set_pending() { return *reinterpret_cast<volatile std::uint32_t*>(0xE000E200U); }

// NOLINTEND(performance-no-int-to-ptr)

constexpr std::uint32_t transmit_mask(std::uint32_t uart_number) { return 1U << (2U * uart_number + 1U); }

inline void enable_uart_interrupts() { set_enabled() = 0x3FU; }

}  // namespace m100::hal::mps2

namespace m100::hal {
// For code that is built for any board: it includes M100_BOARD_HEADER and uses board::
// NOLINTNEXTLINE(misc-unused-alias-decls): used by the files that include this header
namespace board = mps2;
}  // namespace m100::hal
