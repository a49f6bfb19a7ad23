// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/time.h"

namespace m100::ctl {

/// Whether the wind is stronger than the aircraft, by ControlAuthorityMonitor.
struct ControlAuthorityStatus {
  core::Duration exceeded_for{0};              ///< how long the wind has kept the aircraft from its reference
  double disturbance_acceleration_m_s2 = 0.0;  ///< estimated, averaged over 2 s, magnitude on the worse axis
};

}  // namespace m100::ctl
