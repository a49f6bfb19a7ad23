// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace m100::hal {

// The messages by which a simulation drives the time of an emulated board. Emulation is slower than real time, at an
// uneven rate; a board that read its own clock would miss its periods. So the peer sends the time and its byte counts
// over UART0. The board waits for those bytes, runs one tick and reports its own byte counts. Little-endian, unpadded.

/// kBreak: an assertion fails; kHang: the watchdog is started and the program hangs. Both serve to test the reaction;
/// no report follows them.
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
  std::uint32_t autopilot_bytes;  ///< queued for UART1 since the start
  std::uint32_t pose_bytes;       ///< queued for UART2 since the start
  std::uint32_t tick_cycles;      ///< of the processor, interrupts included
  std::uint32_t stack_bytes;      ///< deepest since reset
  std::uint32_t lost_bytes;       ///< that arrived while a ring was full
};

static_assert(sizeof(LockstepStep) == 16 && sizeof(LockstepReport) == 20);

}  // namespace m100::hal
