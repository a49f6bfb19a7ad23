// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/ctl/monitor/control_authority_monitor.h"

#include "firmware/core/maths.h"

namespace m100::ctl {
namespace {

constexpr double kMean_s = 2.0;
constexpr double kDownwind_m = 0.5;
constexpr double kComesBack_m_s = 0.2;

}  // namespace

template <typename T>
void ControlAuthorityMonitor<T>::update_axis(Axis& axis, const est::AxisEstimate<T>& estimate, T reference_m,
                                             T step_s) const {
  const T share = step_s * static_cast<T>(1.0 / kMean_s);
  axis.disturbance_acceleration_m_s2 +=
      (estimate.disturbance_m_s2 - axis.disturbance_acceleration_m_s2) * (share < T(1) ? share : T(1));
  const T downwind = axis.disturbance_acceleration_m_s2 < T(0) ? T(-1) : T(1);
  const bool lost = downwind * axis.disturbance_acceleration_m_s2 > max_disturbance_m_s2_ &&
                    downwind * (estimate.position_m - reference_m) > static_cast<T>(kDownwind_m) &&
                    downwind * estimate.velocity_m_s > static_cast<T>(-kComesBack_m_s);
  axis.exceeded_s = lost ? axis.exceeded_s + step_s : T(0);
}

template <typename T>
void ControlAuthorityMonitor<T>::update(const est::Estimate<T>& estimate, const ref::Window<T>& window, bool flies,
                                        T step_s) {
  if (!flies) {
    x_ = y_ = {};
    return;
  }
  update_axis(x_, estimate.x, window.x[0].position_m, step_s);
  update_axis(y_, estimate.y, window.y[0].position_m, step_s);
}

template <typename T>
T ControlAuthorityMonitor<T>::disturbance_acceleration_m_s2() const {
  const T x = core::abs(x_.disturbance_acceleration_m_s2);
  const T y = core::abs(y_.disturbance_acceleration_m_s2);
  return core::max(x, y);
}

template class ControlAuthorityMonitor<float>;
template class ControlAuthorityMonitor<double>;

}  // namespace m100::ctl
