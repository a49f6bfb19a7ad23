// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/ctl/law/braking.h"

#include <algorithm>

namespace m100::ctl {
namespace {

constexpr double kUsed = 0.95;
constexpr double kCommandPeriod_s = 0.04;
constexpr double kSeen_s = 0.02;
constexpr double kMinReaction_s = 0.35;
constexpr double kDrag_per_s = 0.3;
constexpr double kHolds_m_s2 = 4.0;

double lag_s(const model::StickAxis& axis) {
  const double w = axis.natural_frequency_rad_s;
  const double loop_s = axis.is_first_order() ? axis.time_constant_s : w > 0.0 ? 2.0 * axis.damping_ratio / w : 0.0;
  return axis.transport_delay_s + loop_s;
}

}  // namespace

InverseLags inverse_lags(const model::StickAxis& axis) {
  double first_s = 0.0;
  double second_s2 = 0.0;
  if (axis.is_first_order()) {
    first_s = axis.time_constant_s;
  } else if (axis.natural_frequency_rad_s > 0.0) {
    const double w = axis.natural_frequency_rad_s;
    first_s = 2.0 * axis.damping_ratio / w;
    second_s2 = 1.0 / (w * w);
  } else {
    return {};
  }
  const double left_s = first_s - axis.lead_zero_s;
  return {.first_s = left_s, .second_s2 = second_s2 - axis.lead_zero_s * left_s};
}

double effective_delay_s(const model::StickAxis& axis) { return axis.transport_delay_s + kCommandPeriod_s; }

Braking braking_of(const model::Vehicle& vehicle, double slope_limit) {
  const model::Translation& air = vehicle.translation;
  const double reaction_s = std::max(lag_s(vehicle.pitch), lag_s(vehicle.roll)) + kCommandPeriod_s + kSeen_s;
  const double acceleration_m_s2 = kUsed * model::kGravity_m_s2 * air.tilt_gain * slope_limit;
  return {.acceleration_m_s2 = acceleration_m_s2,
          .max_disturbance_m_s2 = std::min(acceleration_m_s2, kHolds_m_s2),
          .reaction_s = std::max(reaction_s, kMinReaction_s),
          .acts_s = std::max(effective_delay_s(vehicle.pitch), effective_delay_s(vehicle.roll)),
          .unknown_drag_per_s = std::max(kDrag_per_s - air.linear_drag_per_s, 0.0),
          .drag_per_s = std::max(kDrag_per_s, air.linear_drag_per_s)};
}

}  // namespace m100::ctl
