// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/oracle/axis_vehicle.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace m100::oracle {
namespace {

constexpr double kFullStick_counts = 660.0;

struct EffectRow {
  std::string_view name;
  double AxisParameters::*member;
  enum class Way { kIs, kAdds, kFactor } way = Way::kIs;
};
constexpr std::array kEffects{
    EffectRow{"transport_delay", &AxisParameters::delay_s, EffectRow::Way::kAdds},
    EffectRow{"lead_zero", &AxisParameters::lead_s},
    EffectRow{"dead_zone", &AxisParameters::dead_zone_counts},
    EffectRow{"dead_zone_jump", &AxisParameters::jump_counts},
    EffectRow{"trim_offset", &AxisParameters::trim_counts},
    EffectRow{"backlash", &AxisParameters::backlash_counts},
    EffectRow{"saturation", &AxisParameters::saturation},
    EffectRow{"tilt_limit", &AxisParameters::tilt_limit},
    EffectRow{"rate_limit", &AxisParameters::rate_limit_per_s},
    EffectRow{"gain_asymmetry", &AxisParameters::asymmetry},
    EffectRow{"stick_curve", &AxisParameters::exponent},
    EffectRow{"gain_drift", &AxisParameters::drift_per_minute},
    EffectRow{"cross_axis", &AxisParameters::cross},
    EffectRow{"input_product", &AxisParameters::product},
    EffectRow{"product", &AxisParameters::product},
    EffectRow{"gain", &AxisParameters::gain, EffectRow::Way::kFactor},
    EffectRow{"frequency", &AxisParameters::frequency_rad_s, EffectRow::Way::kFactor},
};

}  // namespace

bool set_effect(AxisParameters& parameters, std::string_view name, double value) {
  const auto* const row =
      std::find_if(kEffects.begin(), kEffects.end(), [&](const EffectRow& one) { return one.name == name; });
  if (row == kEffects.end()) {
    return false;
  }
  double& member = parameters.*row->member;
  member = row->way == EffectRow::Way::kAdds     ? member + value
           : row->way == EffectRow::Way::kFactor ? member * value
                                                 : value;
  return true;
}

AxisVehicle::AxisVehicle(const AxisParameters& parameters, double step_s)
    : parameters_(parameters),
      step_s_(step_s),
      own_(static_cast<std::size_t>(kMaxDelay_s / step_s) + 2, 0.0),
      other_(own_) {}

/// The stick as it was a delay ago, interpolated; before the first, the first.
double AxisVehicle::arrived(const std::vector<double>& sent) const {
  const double last = static_cast<double>(count_) - 1.0;
  const double at = std::clamp(last - parameters_.delay_s / step_s_, 0.0, last);
  const auto whole = static_cast<std::size_t>(at);
  const double part = at - std::floor(at);
  const double first = sent[whole % sent.size()];
  return first + part * (sent[std::min(whole + 1, count_ - 1) % sent.size()] - first);
}

double AxisVehicle::command(double own, double other) {
  own_[count_ % own_.size()] = own;
  other_[count_ % other_.size()] = other;
  const double drift = 1.0 + parameters_.drift_per_minute * static_cast<double>(count_) * step_s_ / 60.0;
  ++count_;
  const double stick = arrived(own_);
  const double beside = arrived(other_);
  play_ = std::min(std::max(play_, stick - parameters_.backlash_counts), stick + parameters_.backlash_counts);
  double u = play_ - parameters_.trim_counts;
  u = std::abs(u) > parameters_.dead_zone_counts ? u - std::copysign(parameters_.dead_zone_counts, u) : 0.0;
  u = std::abs(u) > parameters_.jump_counts ? u : 0.0;
  if (parameters_.exponent != 1.0) {
    u = std::copysign(kFullStick_counts * std::pow(std::abs(u) / kFullStick_counts, parameters_.exponent), u);
  }
  u *= 2.0 * (u > 0.0 ? parameters_.asymmetry : 1.0) / (1.0 + parameters_.asymmetry);
  u += parameters_.cross * beside + parameters_.product * stick * beside / kFullStick_counts;
  const double wanted = parameters_.gain * u * drift;
  const double tilt = std::hypot(wanted, parameters_.gain * beside);
  const double cut = tilt > parameters_.tilt_limit ? parameters_.tilt_limit / tilt : 1.0;
  return std::clamp(cut * wanted, -parameters_.saturation, parameters_.saturation);
}

double AxisVehicle::respond(double command) {
  constexpr double kZeroFilter_s = 0.005;
  const double before = response_;
  if (parameters_.lead_s > 0.0) {
    const double slope = (command - filtered_) / kZeroFilter_s;
    filtered_ += step_s_ * slope;
    command += parameters_.lead_s * slope;
  }
  lagged_ = parameters_.lag_s > 0.0 ? lagged_ + (command - lagged_) * (1.0 - std::exp(-step_s_ / parameters_.lag_s))
                                    : command;
  const double pull = parameters_.spring_per_s * std::max(0.0, flown_m_ - parameters_.tether_m);
  const double w = parameters_.frequency_rad_s;
  if (parameters_.first_order) {
    rate_ = w * (lagged_ - pull - response_);
    response_ += step_s_ * rate_;
  } else {
    const auto accel = [&](double y, double v) {
      return w * w * (lagged_ - pull - y) - 2.0 * parameters_.damping * w * v;
    };
    const double a1 = accel(response_, rate_);
    const double a2 = accel(response_ + step_s_ * rate_, rate_ + step_s_ * a1);
    response_ += 0.5 * step_s_ * (2.0 * rate_ + step_s_ * a1);
    rate_ += 0.5 * step_s_ * (a1 + a2);
  }
  if (std::abs(rate_) > parameters_.rate_limit_per_s) {
    rate_ = std::copysign(parameters_.rate_limit_per_s, rate_);
    response_ = before + step_s_ * rate_;
  }
  flown_m_ += step_s_ * before;
  return before;
}

}  // namespace m100::oracle
