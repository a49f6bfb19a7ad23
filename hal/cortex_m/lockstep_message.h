// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace m100::hal {

// How a simulation leads an emulated board through time. Emulation is slower than life and not evenly so; a board that
// read its own clock would miss its periods. So the peer says over UART0 what time it is and how much it has sent, the
// board waits for those bytes, runs one tick and says how much it has sent. Little-endian words, no padding.

/// kBreak: an assertion fails; kHang: the watchdog is started and the program hangs. Both are for the test of what
/// comes then, and no report comes after them.
enum class LockstepOrder : std::uint32_t { kNone = 0, kEngage = 1, kRelease = 2, kEnd = 3, kBreak = 4, kHang = 5 };

/// Peer to board, before each tick.
struct LockstepStep {
  std::uint32_t now_us;           ///< time of the tick
  LockstepOrder order;            ///< of the operator
  std::uint32_t autopilot_bytes;  ///< sent to UART1 since the start
  std::uint32_t pose_bytes;       ///< sent to UART2 since the start
};

/// Board to peer, after each tick.
struct LockstepReport {
  std::uint32_t autopilot_bytes;  ///< sent from UART1 since the start
  std::uint32_t pose_bytes;       ///< sent from UART2 since the start
  std::uint32_t tick_cycles;      ///< of the processor, interrupts included
  std::uint32_t stack_bytes;      ///< deepest since reset
  std::uint32_t lost_bytes;       ///< that came while a ring was full
};

static_assert(sizeof(LockstepStep) == 16 && sizeof(LockstepReport) == 20);

}  // namespace m100::hal
