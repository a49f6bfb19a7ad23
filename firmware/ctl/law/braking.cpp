// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/ctl/law/braking.h"

#include <algorithm>
#include <numbers>

namespace m100::ctl {
namespace {

constexpr double kUsed = 0.95;
constexpr double kCommandPeriod_s = 0.04;
constexpr double kSeen_s = 0.02;
constexpr double kMinReaction_s = 0.35;
constexpr double kMinLag_s = 0.1;
constexpr double kDrag_per_s = 0.3;
constexpr double kHolds_m_s2 = 4.0;

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
  double reaction_s = kMinReaction_s, lag_s = kMinLag_s, lag2_s2 = 0.0, acts_s = 0.0;
  for (const model::StickAxis* const axis : {&vehicle.pitch, &vehicle.roll}) {
    const InverseLags lags = inverse_lags(*axis);
    acts_s = std::max(acts_s, effective_delay_s(*axis));
    reaction_s = std::max(reaction_s, effective_delay_s(*axis) + lags.first_s + axis->lead_zero_s + kSeen_s);
    lag_s = std::max(lag_s, axis->transport_delay_s + lags.first_s);
    lag2_s2 = std::max(lag2_s2, lags.second_s2);
  }
  const double tilted_m_s2 = model::kGravity_m_s2 * air.tilt_gain * std::numbers::sqrt2 * slope_limit;
  const double acceleration_m_s2 = kUsed * model::kGravity_m_s2 * air.tilt_gain * slope_limit;
  return {.acceleration_m_s2 = acceleration_m_s2,
          .tilted_m_s2 = tilted_m_s2,
          .max_disturbance_m_s2 = std::min(acceleration_m_s2, kHolds_m_s2),
          .reaction_s = reaction_s,
          .lag_s = lag_s,
          .lag2_s2 = lag2_s2,
          .acts_s = acts_s,
          .unknown_drag_per_s = std::max(kDrag_per_s - air.linear_drag_per_s, 0.0),
          .drag_per_s = std::max(kDrag_per_s, air.linear_drag_per_s)};
}

}  // namespace m100::ctl
