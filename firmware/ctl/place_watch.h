// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "firmware/ctl/braking.h"
#include "firmware/est/estimate.h"
#include "firmware/ref/window.h"

namespace m100::ctl {

/// Detects a wind in which the aircraft cannot hold its position. Both conditions must be true on one horizontal axis,
/// without interruption:
///   - the estimated push, averaged over 2 s, exceeds the push that the aircraft can resist (Braking::holds_m_s2);
///   - the aircraft is more than half a metre downwind of its reference and returns at less than 0.2 m/s.
/// Either one alone is normal: a gust is over in a second, and a far goal upwind takes time. T is float or double.
template <typename T>
class PlaceWatch {
 public:
  explicit PlaceWatch(const Braking& braking) : holds_m_s2_(static_cast<T>(braking.holds_m_s2)) {}

  /// Once per tick. @param flies whether the law flies; if not, nothing is watched.
  void update(const est::Estimate<T>& estimate, const ref::Window<T>& window, bool flies, T step_s);

  /// How long the position has not been held, on the worse axis.
  T lost_s() const { return x_.lost_s > y_.lost_s ? x_.lost_s : y_.lost_s; }
  /// The averaged push, on the axis that is worse.
  T push_m_s2() const;

 private:
  struct Axis {
    T push_m_s2{0};
    T lost_s{0};
  };
  void watch(Axis& axis, const est::AxisEstimate<T>& estimate, T reference_m, T step_s) const;

  T holds_m_s2_;
  Axis x_, y_;
};

extern template class PlaceWatch<float>;
extern template class PlaceWatch<double>;

}  // namespace m100::ctl
