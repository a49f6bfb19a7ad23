// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/world/axis_motion.h"

#include <algorithm>
#include <cmath>

namespace m100::sim {
namespace {

constexpr double kCentre_vrc = 1024.0;
constexpr double kStickPeriod_s = 0.01;  // only the slew of a command would depend on it, and it is not used here

}  // namespace

AxisMotion::AxisMotion(const model::StickAxis& axis, double extra_delay_s)
    : axis_(axis),
      law_(axis, kStickPeriod_s),
      response_(axis),
      extra_delay_s_(extra_delay_s),
      delay_s_(axis.transport_delay_s + extra_delay_s),
      stick_counts_(axis.trim_counts) {
  law_.rest_at(axis.trim_counts);
  inputs_[0].value = axis.trim_counts;  // before the first command the aircraft is trimmed
}

void AxisMotion::store_input(double value, bool direct) {
  const Input& last = inputs_[newest_];
  if (last.value == value && last.direct == direct) {
    return;
  }
  newest_ = (newest_ + 1) % kMaxInputs;
  inputs_[newest_] = {.since_s = time_s_, .value = value, .direct = direct};
}

void AxisMotion::set_stick(double counts) {
  stick_counts_ = counts - kCentre_vrc;
  store_input(law_.moved(stick_counts_), false);
}

void AxisMotion::set_parameters(const model::StickAxis& axis) {
  const bool same_order = axis.is_first_order() == axis_.is_first_order();
  axis_ = axis;
  law_ = model::StickLaw<double>(axis, kStickPeriod_s);
  response_ = model::ResponseLaw<double>(axis);
  law_.rest_at(stick_counts_);
  delay_s_ = axis.transport_delay_s + extra_delay_s_;
  if (!same_order) {
    state_ = output_;
    state_rate_ = output_rate_;
  }
}

void AxisMotion::set_direct(double command) { store_input(command, true); }

const AxisMotion::Input& AxisMotion::delayed() const {
  while (acting_ != newest_ && inputs_[(acting_ + 1) % kMaxInputs].since_s + delay_s_ <= time_s_ + 1e-9) {
    acting_ = (acting_ + 1) % kMaxInputs;
  }
  return inputs_[acting_];
}

double AxisMotion::commanded() const {
  const Input& input = delayed();
  return input.direct ? input.value : law_.drifted(law_.shaped(input.value), time_s_);
}

void AxisMotion::advance(double step_s, double added, double authority) {
  const double target = law_.limited(commanded() + added);
  const double before = output_;
  if (axis_.time_constant_s > 0.0) {
    const double keep = std::exp(-step_s * authority / axis_.time_constant_s);
    state_ = target + (state_ - target) * keep;
    output_ = state_;
  } else if (axis_.natural_frequency_rad_s > 0.0) {
    const double w = axis_.natural_frequency_rad_s * authority;
    const auto acceleration = [&](double z, double rate) {
      return w * w * (target - z) - 2.0 * axis_.damping_ratio * w * rate;
    };
    const double middle_rate = state_rate_ + 0.5 * step_s * acceleration(state_, state_rate_);
    const double middle = state_ + 0.5 * step_s * state_rate_;
    state_ += step_s * middle_rate;
    state_rate_ += step_s * acceleration(middle, middle_rate);
    state_rate_ = response_.rate(state_rate_);
    output_ = state_ + axis_.lead_zero_s * state_rate_;
  } else {
    output_ = target;
  }
  if (response_.acts()) {
    output_ = response_.value(before, output_, step_s);
    state_ = axis_.time_constant_s > 0.0 ? output_ : state_;
  }
  output_rate_ = (output_ - before) / step_s;
  time_s_ += step_s;
}

}  // namespace m100::sim
