// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/time.h"

namespace m100::est {

/// What the supervisor needs to know of the estimate.
struct EstimateStatus {
  core::Duration pose_age{core::Duration::max()};  ///< of the newest pose that the estimate used
  double error_m = 0.0;                            ///< three sigmas of the predicted position, on the worse axis
  bool healthy = false;                            ///< Estimate::healthy
};

}  // namespace m100::est
