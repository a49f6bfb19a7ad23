// SPDX-License-Identifier: BSD-3-Clause
// What a program that breaks leaves behind: argument assertion | undefined | address | overflow | interrupt | abort.
#include <array>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "firmware/core/assert.h"
#include "hal/cortex_m/exceptions.h"
#include "hal/cortex_m/mps2.h"
#include "hal/cortex_m/semihosting.h"

namespace {

/// Deviation: a recursion without an end, to overflow the stack.
[[gnu::noinline]] std::uint32_t dig(std::uint32_t depth) {
  std::array<volatile std::uint32_t, 64> frame;
  frame[depth % 64] = depth;
  return depth == 0xFFFFFFFFU ? 0 : dig(depth + 1) + frame[depth % 64];
}

}  // namespace

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
  }
  return 0;
}
