// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/time.h"

namespace m100::safety {

/// What the supervisor needs to know of the link to the autopilot.
struct LinkStatus {
  core::Duration telemetry_age{core::Duration::max()};  ///< as LinkHealth::telemetry_age
  bool in_control = false;                              ///< AuthorityStage::kInControl
  bool mode_f = false;                                  ///< the pilot's switch is at F, or may be (ModeSwitch)
};

}  // namespace m100::safety
