// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/time.h"

namespace m100::app {

/// When the tick after one is due that was due at `due` and began at `now`, by the board's own clock. What was late by
/// a little is made good; after a stall (promise R9) time is counted anew, or all the ticks that were missed would
/// follow without a pause, each with the same poses and the same telemetry.
constexpr core::TimePoint tick_after(core::TimePoint due, core::TimePoint now) {
  return (now - due > 2 * core::kTickPeriod ? now : due) + core::kTickPeriod;
}

}  // namespace m100::app
