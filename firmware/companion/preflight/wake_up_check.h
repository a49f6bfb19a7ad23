// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "firmware/companion/preflight/check_result.h"
#include "firmware/core/time.h"

namespace m100::companion::preflight {

/// How late the ticks of a flight would be on a busy board.
struct WakeUps {
  std::uint32_t ticks = 0;
  std::uint32_t late = 0;  ///< more than kLate
  core::Duration worst{0};
  bool real_time = false;  ///< SCHED_FIFO was granted
};

/// Two ticks: the flight counts it as a stall. A flight has at most one in 10 000.
inline constexpr core::Duration kLate = 2 * core::kTickPeriod;
/// Five ticks: no tick of a flight may be later.
inline constexpr core::Duration kTooLate = 5 * core::kTickPeriod;

/// Ticks as a flight does, with its priority if that is granted, and reads a terminal in each tick. Beside it, at
/// normal priority, one loop per processor, at least two, computes, and one thread writes to a file in the folder and
/// waits for the disk.
/// @returns the lateness of the end of each tick's read, against the tick's deadline.
WakeUps measure_wake_ups(const std::string& folder, core::Duration duration);

CheckResult judge_wake_ups(const WakeUps& measured);

}  // namespace m100::companion::preflight
