// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace m100::ctl {

/// Where the aircraft is in its fence.
struct GeofenceStatus {
  double reserve_m = 1e6;   ///< from the point where the aircraft can stop to the side towards which it flies (x, y)
  double outside_m = -1e6;  ///< estimated position beyond the nearest side, floor or ceiling; negative: inside
};

}  // namespace m100::ctl
