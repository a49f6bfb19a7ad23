// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "firmware/companion/preflight/check_result.h"
#include "firmware/core/time.h"

namespace m100::companion::preflight {

/// How late the ticks of a flight are on a busy board, as measured.
struct WakeUps {
  std::uint32_t ticks = 0;
  std::uint32_t late = 0;  ///< more than kLate
  core::Duration worst{0};
  bool real_time = false;  ///< SCHED_FIFO was granted
};

/// Two periods, as of a stall in flight; of a flight's ticks at most one in 10 000 may be later.
inline constexpr core::Duration kLate = 2 * core::kTickPeriod;
/// Five periods: no tick of a flight may be later.
inline constexpr core::Duration kTooLate = 5 * core::kTickPeriod;

/// Wakes up every tick as a flight does, with its priority if that is granted, and reads a terminal. Meanwhile threads
/// of normal priority load the processors and write to a file in the folder. Lateness is that of the end of the read,
/// against the tick's deadline.
WakeUps measure_wake_ups(const std::string& folder, core::Duration duration);

CheckResult judge_wake_ups(const WakeUps& measured);

}  // namespace m100::companion::preflight
