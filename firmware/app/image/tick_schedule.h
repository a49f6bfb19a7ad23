// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/time.h"

namespace m100::app {

/// Due time of the next tick, by the board's own clock, after a tick that was due at `due` and began at `now`. A delay
/// of up to two periods is made up for. After a stall (promise R9) it is one period after `now`, so that the missed
/// ticks do not follow without a pause.
constexpr core::TimePoint tick_after(core::TimePoint due, core::TimePoint now) {
  return (now - due > 2 * core::kTickPeriod ? now : due) + core::kTickPeriod;
}

}  // namespace m100::app
