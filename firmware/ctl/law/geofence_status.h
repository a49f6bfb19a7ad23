// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace m100::ctl {

/// Where the aircraft is in its fence.
struct GeofenceStatus {
  double reserve_m = 1e6;   ///< from the point where the aircraft can stop to the side towards which it flies (x, y)
  double outside_m = -1e6;  ///< estimated position beyond the nearest side, floor or ceiling; negative: inside
  std::uint32_t stops = 0;  ///< stops before a side that the reference did not contain, since the law flies
};

}  // namespace m100::ctl
