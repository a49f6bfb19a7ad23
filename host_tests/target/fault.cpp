// SPDX-License-Identifier: BSD-3-Clause
// Fails in one chosen way, so that a test can check the exit status and the text. Argument: assertion | undefined |
// address | overflow | interrupt | abort | hang | fed.
#include <array>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "firmware/core/assert.h"
#include "hal/cortex_m/cmsdk_watchdog.h"
#include "hal/cortex_m/exceptions.h"
#include "hal/cortex_m/mps2.h"
#include "hal/cortex_m/semihosting.h"
#include "hal/cortex_m/systick_clock.h"

namespace {

m100::hal::SysTickClock* system_clock = nullptr;

/// Deviation: an endless recursion, to overflow the stack.
[[gnu::noinline]] std::uint32_t dig(std::uint32_t depth) {
  std::array<volatile std::uint32_t, 64> frame;
  frame[depth % 64] = depth;
  return depth == 0xFFFFFFFFU ? 0 : dig(depth + 1) + frame[depth % 64];
}

/// Starts a watchdog of 20 ms and feeds it in each of 8 periods of 10 ms, or never.
void hang(bool fed) {
  using namespace m100;
  static hal::SysTickClock clock(hal::mps2::systick(), hal::mps2::kClock_hz, 10000);
  hal::CmsdkWatchdog watchdog(hal::mps2::watchdog(), hal::mps2::watchdog_lock(), hal::mps2::kClock_hz);
  system_clock = &clock;
  clock.start();
  watchdog.start(std::chrono::milliseconds(20));
  const core::TimePoint start = clock.now();
  for (int period = 1; period <= 8; ++period) {
    clock.sleep_until(start + period * std::chrono::milliseconds(10));
    if (fed) {
      watchdog.feed();
    }
  }
  hal::print("never bitten\n");
}

}  // namespace

extern "C" {
void SysTick_Handler() { system_clock->on_period(); }
void NMI_Handler() {
  m100::hal::print("watchdog\n");
  m100::hal::exit_emulator(m100::hal::kExitOfWatchdog);
}
}

int main() {
  const std::string_view how = m100::hal::argument(1);
  if (how == "assertion") {
    m100::core::set_assertion_handler(&m100::hal::fail_assertion);
    M100_ASSERT(how.empty());
  } else if (how == "undefined") {
    asm volatile("udf #1");
  } else if (how == "address") {
    *reinterpret_cast<volatile std::uint32_t*>(0x90000000U) = 1;
  } else if (how == "overflow") {
    return dig(0) == 1 ? 2 : 3;
  } else if (how == "interrupt") {
    m100::hal::mps2::enable_uart_interrupts();
    m100::hal::mps2::set_pending() = 1U << 3U;
    asm volatile("dsb\n isb");
  } else if (how == "abort") {
    std::abort();
  } else if (how == "hang" || how == "fed") {
    hang(how == "fed");
  }
  return 0;
}
