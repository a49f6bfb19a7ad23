// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/maths.h"
#include "firmware/core/time.h"
#include "firmware/model/vehicle.h"

namespace m100::ctl {

/// Gains of the height loop from the climb dynamics of the vehicle. The limits are those of `base`.
///
/// The climb loop is modelled as one lag T plus its delay D. T is tau, at least 50 ms, or 2 z / w_n. With u = Kp e - Kd
/// w, w the climb speed, the characteristic polynomial is T s^2 + (1 + Kd) s + Kp. Its natural frequency is limited by
/// the delay, and to 4 rad/s. Its damping is kDamping, or more where Kd is 0. At least 6 dB of gain margin and 45
/// degrees of phase margin remain for T of 0.05 to 1 s and D to 0.35 s.
model::AltitudeGains design_altitude(const model::StickAxis& climb, const model::AltitudeGains& base);

/// Reference of the height loop.
template <typename T>
struct HeightReference {
  T height_m{0};
  T climb_m_s{0};          ///< w_ref
  T climb_command_m_s{0};  ///< w_cmd: the command that makes the vehicle climb with w_ref, ahead of it by the lag
};

/// Height PID (paper, III-E.2) with feed-forward:
///   u = w_cmd + Kp e + I + Kd (w_ref - w),  e = z_ref - z,  I' = Ki e, I in [integral_min, integral_max]
/// The derivative acts on climb speeds, so that a step of the reference height gives it no kick. The integral is frozen
/// while the output is at its limit and e would drive it further. Output within +-climb_limit.
template <typename T>
class AltitudePid {
 public:
  explicit AltitudePid(const model::AltitudeGains& gains)
      : proportional_per_s_(static_cast<T>(gains.proportional_per_s)),
        derivative_(static_cast<T>(gains.derivative)),
        integral_per_s2_(static_cast<T>(gains.integral_per_s2)),
        integral_min_m_s_(static_cast<T>(gains.integral_min_m_s)),
        integral_max_m_s_(static_cast<T>(gains.integral_max_m_s)),
        climb_limit_m_s_(static_cast<T>(gains.climb_limit_m_s)) {}

  T update(const HeightReference<T>& reference, T height_m, T climb_m_s, T step_s) {
    const T error = reference.height_m - height_m;
    const T limit = climb_limit_m_s_;
    const T steady =
        reference.climb_command_m_s + proportional_per_s_ * error + derivative_ * (reference.climb_m_s - climb_m_s);
    const T integral =
        core::clamp(integral_m_s_ + integral_per_s2_ * error * step_s, integral_min_m_s_, integral_max_m_s_);
    const bool winds_up = (steady + integral > limit && error > T(0)) || (steady + integral < -limit && error < T(0));
    if (!winds_up) {
      integral_m_s_ = integral;
    }
    return core::clamp(steady + integral_m_s_, -limit, limit);
  }
  void reset() { integral_m_s_ = T(0); }
  T integral_m_s() const { return integral_m_s_; }

 private:
  T proportional_per_s_;
  T derivative_;
  T integral_per_s2_;
  T integral_min_m_s_;
  T integral_max_m_s_;
  T climb_limit_m_s_;
  T integral_m_s_{0};
};

}  // namespace m100::ctl
