// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/time.h"

namespace m100::safety {

/// What the supervisor needs to know of the link to the autopilot.
struct LinkStatus {
  core::Duration telemetry_age{core::Duration::max()};  ///< since the newest frame of the autopilot
  bool in_control = false;                              ///< the autopilot says that we command
  bool mode_f = false;                                  ///< the pilot's switch stands at F
};

}  // namespace m100::safety
