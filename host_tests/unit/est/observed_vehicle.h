// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/model/vehicle.h"

namespace m100::est {

/// The vehicle of these tests; fields that are not set have the model's defaults.
inline model::Vehicle vehicle() {
  model::Vehicle v;
  for (model::StickAxis* axis : {&v.roll, &v.pitch}) {
    axis->natural_frequency_rad_s = 9.36;
    axis->damping_ratio = 0.68;
    axis->transport_delay_s = 0.033;
  }
  v.climb.time_constant_s = 0.334;
  v.yaw_rate.time_constant_s = 0.19;
  return v;
}

}  // namespace m100::est
