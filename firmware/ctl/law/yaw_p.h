// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/maths.h"
#include "firmware/model/vehicle.h"

namespace m100::ctl {

/// Yaw (paper, III-E.2): rate = rate_ref + K wrap(yaw_ref - yaw), along the shorter rotation, within +-rate_limit.
template <typename T>
class YawP {
 public:
  explicit YawP(const model::YawGain& gain)
      : proportional_per_s_(static_cast<T>(gain.proportional_per_s)),
        rate_limit_rad_s_(static_cast<T>(gain.rate_limit_rad_s)) {}
  T update(T reference_rad, T reference_rate_rad_s, T yaw_rad) const {
    const T error = core::wrap_pi(reference_rad - yaw_rad);
    return core::clamp(reference_rate_rad_s + proportional_per_s_ * error, -rate_limit_rad_s_, rate_limit_rad_s_);
  }

 private:
  T proportional_per_s_;
  T rate_limit_rad_s_;
};

}  // namespace m100::ctl
