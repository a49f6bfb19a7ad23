// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/stick_axis.h"

#include <algorithm>
#include <cmath>

namespace m100::sim {
namespace {

constexpr double kCentre_vrc = 1024.0;
constexpr double kTravel_vrc = 660.0;

}  // namespace

AxisLaw law_of(const model::AttitudeAxis& axis) {
  return {.scale_per_count = axis.scale_rad_per_count,
          .time_constant_s = axis.time_constant_s,
          .natural_frequency_rad_s = axis.natural_frequency_rad_s,
          .damping_ratio = axis.damping_ratio,
          .transport_delay_s = axis.transport_delay_s,
          .lead_zero_s = axis.lead_zero_s,
          .dead_zone_counts = axis.dead_zone_counts,
          .dead_zone_shape = axis.dead_zone_shape,
          .trim_counts = axis.trim_counts,
          .saturation = axis.saturation_rad,
          .rate_limit = axis.rate_limit_rad_s,
          .gain_asymmetry = axis.gain_asymmetry,
          .stick_exponent = axis.stick_exponent,
          .backlash_counts = axis.backlash_counts,
          .gain_drift_per_minute = axis.gain_drift_per_minute};
}

AxisLaw law_of(const model::RateAxis& axis) {
  return {.scale_per_count = axis.scale_per_count,
          .time_constant_s = axis.time_constant_s,
          .natural_frequency_rad_s = axis.natural_frequency_rad_s,
          .damping_ratio = axis.damping_ratio,
          .transport_delay_s = axis.transport_delay_s,
          .lead_zero_s = axis.lead_zero_s,
          .dead_zone_counts = axis.dead_zone_counts,
          .dead_zone_shape = axis.dead_zone_shape,
          .trim_counts = axis.trim_counts,
          .saturation = axis.limit,
          .rate_limit = axis.rate_limit,
          .gain_asymmetry = axis.gain_asymmetry,
          .stick_exponent = axis.stick_exponent,
          .backlash_counts = axis.backlash_counts,
          .gain_drift_per_minute = axis.gain_drift_per_minute};
}

StickAxis::StickAxis(const AxisLaw& law, double extra_delay_s)
    : law_(law), delay_s_(law.transport_delay_s + extra_delay_s), backlash_(law.trim_counts) {
  past_[0].value = law.trim_counts;  // before the first command the aircraft stands balanced
}

void StickAxis::remember(double value, bool direct) {
  const Input& last = past_[newest_];
  if (last.value == value && last.direct == direct) {
    return;
  }
  newest_ = (newest_ + 1) % kPast;
  past_[newest_] = {.since_s = time_s_, .value = value, .direct = direct};
}

void StickAxis::set_stick(double counts) {
  const double offset = counts - kCentre_vrc;
  backlash_ = std::clamp(backlash_, offset - law_.backlash_counts, offset + law_.backlash_counts);
  remember(backlash_, false);
}

void StickAxis::set_direct(double command) { remember(command, true); }

const StickAxis::Input& StickAxis::delayed() const {
  while (in_force_ != newest_ && past_[(in_force_ + 1) % kPast].since_s + delay_s_ <= time_s_ + 1e-9) {
    in_force_ = (in_force_ + 1) % kPast;
  }
  return past_[in_force_];
}

double StickAxis::static_law(double counts) const {
  double u = counts - law_.trim_counts;
  const double magnitude = std::abs(u);
  if (magnitude <= law_.dead_zone_counts) {
    return 0.0;
  }
  if (law_.dead_zone_shape == model::DeadZoneShape::kContinuous) {
    u = std::copysign(magnitude - law_.dead_zone_counts, u);
  }
  if (law_.stick_exponent != 1.0) {
    u = std::copysign(kTravel_vrc * std::pow(std::abs(u) / kTravel_vrc, law_.stick_exponent), u);
  }
  // gain_asymmetry is positive over negative; the scale is their mean.
  const double side = 2.0 * (u > 0.0 ? law_.gain_asymmetry : 1.0) / (1.0 + law_.gain_asymmetry);
  const double gain = law_.scale_per_count * side;
  return gain * (1.0 + law_.gain_drift_per_minute * time_s_ / 60.0) * u;
}

double StickAxis::commanded() const {
  const Input& input = delayed();
  return input.direct ? input.value : static_law(input.value);
}

void StickAxis::advance(double step_s, double added, double authority) {
  double target = commanded() + added;
  if (law_.saturation > 0.0) {
    target = std::clamp(target, -law_.saturation, law_.saturation);
  }
  const double before = output_;
  if (law_.time_constant_s > 0.0) {
    const double keep = std::exp(-step_s * authority / law_.time_constant_s);
    state_ = target + (state_ - target) * keep;
    output_ = state_;
  } else if (law_.natural_frequency_rad_s > 0.0) {
    const double w = law_.natural_frequency_rad_s * authority;
    const auto acceleration = [&](double z, double rate) {
      return w * w * (target - z) - 2.0 * law_.damping_ratio * w * rate;
    };
    const double middle_rate = state_rate_ + 0.5 * step_s * acceleration(state_, state_rate_);
    const double middle = state_ + 0.5 * step_s * state_rate_;
    state_ += step_s * middle_rate;
    state_rate_ += step_s * acceleration(middle, middle_rate);
    if (law_.rate_limit > 0.0) {
      state_rate_ = std::clamp(state_rate_, -law_.rate_limit, law_.rate_limit);
    }
    output_ = state_ + law_.lead_zero_s * state_rate_;
  } else {
    output_ = target;
  }
  if (law_.rate_limit > 0.0) {
    output_ = std::clamp(output_, before - law_.rate_limit * step_s, before + law_.rate_limit * step_s);
    if (law_.time_constant_s > 0.0) {
      state_ = output_;
    }
  }
  output_rate_ = (output_ - before) / step_s;
  time_s_ += step_s;
}

}  // namespace m100::sim
