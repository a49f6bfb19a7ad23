// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/ctl/fence_keeper.h"

#include "firmware/core/maths.h"
#include "firmware/model/tilt_limit.h"

namespace m100::ctl {
namespace {

constexpr double kGoalMargin_m = 0.2;         // from a side to the nearest goal: overshoot and tracking error
constexpr double kLargestMarginShare = 0.25;  // of a box that is narrow
// Transport 55 ms, command period 40 ms, attitude loop 2 zeta / w = 0.23 s. The test compares the sum with the way of
// an aircraft of that loop, over speeds, tilts and winds.
constexpr double kReaction_s = 0.35;
constexpr double kStillGaining_s = 0.3;
// The law tilts by degrees where it brakes, not at once: a tenth less than the limit gives.
constexpr double kBraking_m_s2 = 0.89 * model::acceleration_at_limit_m_s2(model::Translation{}.tilt_limit_rad);
constexpr double kLeastBraking_m_s2 = 1.0;
constexpr double kGustShare = 0.3;   // of the wind, as an amplitude
constexpr double kDrag_per_s = 0.3;  // a free rotor aircraft: published 0.2 to 0.5
constexpr double kBlend_m = 0.4;     // over which braking is taken up
constexpr double kBehind_m = 3.0;    // a goal so far behind takes all the tilt
constexpr double kSigmas = 3.0;

}  // namespace

template <typename T>
typename FenceKeeper<T>::Side FenceKeeper<T>::side_of(const core::Fence::Side& side) {
  const double width_m = side.high_m - side.low_m;
  const double margin_m = kGoalMargin_m < kLargestMarginShare * width_m ? kGoalMargin_m : kLargestMarginShare * width_m;
  return {.low_m = static_cast<T>(side.low_m),
          .high_m = static_cast<T>(side.high_m),
          .goal_low_m = static_cast<T>(side.low_m + margin_m),
          .goal_high_m = static_cast<T>(side.high_m - margin_m)};
}

template <typename T>
FenceKeeper<T>::FenceKeeper(const core::Fence& fence)
    : x_(side_of(fence.side[core::Fence::kX])),
      y_(side_of(fence.side[core::Fence::kY])),
      z_(side_of(fence.side[core::Fence::kZ])),
      gusts_m_s2_(static_cast<T>(kDrag_per_s * kGustShare * fence.wind_m_s)) {}

template <typename T>
void FenceKeeper<T>::hold_axis(Axis& window, const Side& side, const est::AxisEstimate<T>& estimate, T tilt_sign) {
  for (ref::AxisReference<T>& r : window) {
    const T held_m = core::clamp(r.position_m, side.goal_low_m, side.goal_high_m);
    r = held_m == r.position_m ? r : ref::AxisReference<T>{.position_m = held_m};
  }
  const bool up = estimate.velocity_m_s > T(0);
  const T direction = up ? T(1) : T(-1);
  const T speed_m_s = direction * estimate.velocity_m_s;
  const T wind_m_s2 = direction * estimate.disturbance_m_s2;
  const T push_m_s2 = (wind_m_s2 > T(0) ? wind_m_s2 : T(0)) + gusts_m_s2_;
  const T left_m_s2 = static_cast<T>(kBraking_m_s2) - push_m_s2;
  constexpr T kLeast = static_cast<T>(kLeastBraking_m_s2);
  const T braking_m_s2 = left_m_s2 > kLeast ? left_m_s2 : kLeast;
  const T tilted_m_s2 = direction * tilt_sign * static_cast<T>(model::kGravity_m_s2) * estimate.tilt_rad;
  const T gained_m_s = ((tilted_m_s2 > T(0) ? tilted_m_s2 : T(0)) + push_m_s2) * static_cast<T>(kStillGaining_s);
  const T top_m_s = speed_m_s + gained_m_s;
  const T stop_m = speed_m_s * static_cast<T>(kReaction_s) +
                   gained_m_s * static_cast<T>(kReaction_s - 0.5 * kStillGaining_s) +
                   top_m_s * top_m_s / (T(2) * braking_m_s2);
  const T room_m = (up ? side.high_m - estimate.position_m : estimate.position_m - side.low_m) - stop_m;
  reserve_m_ = room_m < reserve_m_ ? room_m : reserve_m_;
  const T sigma_m = core::sqrt(estimate.position_variance_m2);
  const T share =
      core::clamp((static_cast<T>(kSigmas) * sigma_m - room_m) * static_cast<T>(1.0 / kBlend_m) + T(1), T(0), T(1));
  // Below walking pace the goal decides: at rest beside a side nothing has to be braked.
  constexpr T kSlow_m_s = static_cast<T>(0.3);
  if (share <= T(0) || speed_m_s < kSlow_m_s) {
    return;
  }
  brakes_ = true;
  const T behind_m = estimate.position_m - direction * static_cast<T>(kBehind_m);
  for (ref::AxisReference<T>& r : window) {
    r.position_m += share * (behind_m - r.position_m);
    r.velocity_m_s -= share * r.velocity_m_s;
    r.acceleration_m_s2 -= share * r.acceleration_m_s2;
  }
}

template <typename T>
void FenceKeeper<T>::hold(ref::Window<T>& window, const est::Estimate<T>& estimate) {
  brakes_ = false;
  reserve_m_ = static_cast<T>(1e6);
  hold_axis(window.x, x_, estimate.x, T(1));
  hold_axis(window.y, y_, estimate.y, T(-1));
  const T held_m = core::clamp(window.height.position_m, z_.goal_low_m, z_.goal_high_m);
  if (held_m != window.height.position_m) {
    window.height = {.position_m = held_m};
  }
}

template class FenceKeeper<float>;
template class FenceKeeper<double>;

}  // namespace m100::ctl
