// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/maths.h"
#include "firmware/ctl/law/braking.h"
#include "firmware/ctl/law/slope_limit.h"
#include "firmware/est/estimate.h"
#include "firmware/mpc/gain_table.h"
#include "firmware/ref/window.h"

namespace m100::ctl {

/// Bandwidth w of the fallback law in rad/s, from the delay of the vehicle file for which the tables were made:
///   w = 0.463 / (t + 0.2 s),   t = Braking::reaction_s, the delay from a command until the attitude is seen to follow.
/// With 1.5 times the assumed gain the open loop 1.5 (2 w s + w^2) / s^2 has its crossover at 3.04 w, and a phase
/// margin of 80.7 degrees there. It therefore tolerates a delay of 0.463 / w, which is t and another 0.2 s.
template <typename T>
T fallback_rate_per_s(const Braking& braking) {
  return static_cast<T>(0.463 / (braking.reaction_s + 0.2));
}

/// The law of one horizontal axis after a limit cycle was detected. It is slow, has no prediction, and compensates the
/// observer's wind and trim slowly.
///   a = a_ref + 2 w (v_ref + clamp(w/2 (p_ref - p), 1 m/s) - v),   slope = +-(a + c v_ref) / g + held
/// held is the slope that cancels the estimated wind and trim (-+d / g, less the trim angle at that slope), after a
/// low-pass of time constant 1 / w. T is float or double.
template <typename T>
class FallbackLaw {
 public:
  /// @returns the slope to command, limited so that slope + trim keeps the axis' limits. The caller limits both axes
  ///   together.
  T slope(const est::AxisEstimate<T>& estimate, const ref::AxisReference<T>& reference, const mpc::GainTable<T>& table,
          T rate_per_s, T step_s) {
    constexpr T kMax_m_s = T(1);
    const T per_acceleration = table.tilt_sign / (table.acceleration_per_tilt * table.input_gain);
    const auto without_trim = [&estimate](T slope) { return slope - added_slope(slope, estimate.input_offset_rad); };
    const T needed = without_trim(-per_acceleration * estimate.disturbance_m_s2);
    const T share = began_ ? core::clamp(rate_per_s * step_s, T(0), T(1)) : T(1);
    began_ = true;
    held_ += share * (needed - held_);
    const T nearer_m_s =
        core::clamp(T(0.5) * rate_per_s * (reference.position_m - estimate.position_m), -kMax_m_s, kMax_m_s);
    const T wanted_m_s2 = reference.acceleration_m_s2 + table.drag_per_s * reference.velocity_m_s +
                          T(2) * rate_per_s * (reference.velocity_m_s + nearer_m_s - estimate.velocity_m_s);
    return core::clamp(per_acceleration * wanted_m_s2 + held_, without_trim(table.input_min_slope),
                       without_trim(table.input_max_slope));
  }
  void reset() { began_ = false; }

 private:
  T held_{0};
  bool began_ = false;
};

}  // namespace m100::ctl
