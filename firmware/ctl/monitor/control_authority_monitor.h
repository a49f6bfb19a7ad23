// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/ctl/law/braking.h"
#include "firmware/ctl/monitor/control_authority_status.h"
#include "firmware/est/estimate.h"
#include "firmware/ref/window.h"

namespace m100::ctl {

/// Detects a wind in which the aircraft cannot hold its position. Both conditions must be true on one horizontal axis,
/// without interruption:
///   - the estimated disturbance, averaged over 2 s, exceeds the one that the aircraft can resist
///     (Braking::max_disturbance_m_s2);
///   - the aircraft is more than half a metre downwind of its reference and returns at less than 0.2 m/s.
/// Either one alone is normal: a gust is over in a second, and a far goal upwind takes time. T is float or double.
template <typename T>
class ControlAuthorityMonitor {
 public:
  explicit ControlAuthorityMonitor(const Braking& braking)
      : max_disturbance_m_s2_(static_cast<T>(braking.max_disturbance_m_s2)) {}

  /// Once per tick. @param flies whether the law flies; if not, mean and time are reset.
  void update(const est::Estimate<T>& estimate, const ref::Window<T>& window, bool flies, T step_s);

  /// How long both conditions have been true, on the worse axis.
  T exceeded_s() const { return x_.exceeded_s > y_.exceeded_s ? x_.exceeded_s : y_.exceeded_s; }
  /// Magnitude of the averaged disturbance, on the axis where it is larger.
  T disturbance_acceleration_m_s2() const;

  ControlAuthorityStatus status() const {
    return {.exceeded_for = core::Duration(static_cast<core::Duration::rep>(exceeded_s() * T(1e6))),
            .disturbance_acceleration_m_s2 = static_cast<double>(disturbance_acceleration_m_s2())};
  }

 private:
  struct Axis {
    T disturbance_acceleration_m_s2{0};
    T exceeded_s{0};
  };
  void update_axis(Axis& axis, const est::AxisEstimate<T>& estimate, T reference_m, T step_s) const;

  T max_disturbance_m_s2_;
  Axis x_, y_;
};

extern template class ControlAuthorityMonitor<float>;
extern template class ControlAuthorityMonitor<double>;

}  // namespace m100::ctl
