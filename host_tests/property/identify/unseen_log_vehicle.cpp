// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/property/identify/unseen_log_vehicle.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace m100::host_tests {

double UnseenLogVehicle::arrived(const std::vector<double>& stick, std::size_t now) const {
  const double at = static_cast<double>(now) - traits_.delay_s / kUnseenLogStep_s;
  const double last = static_cast<double>(stick.size()) - 1.0;
  const double inside = std::clamp(at, 0.0, last);
  const auto whole = static_cast<std::size_t>(inside);
  const double part = inside - std::floor(inside);
  return stick[whole] + part * (stick[std::min(whole + 1, stick.size() - 1)] - stick[whole]);
}

double UnseenLogVehicle::command(const UnseenLogSticks& sticks, std::size_t now) {
  const double stick = arrived(sticks.own, now);
  play_ = std::min(std::max(play_, stick - traits_.backlash_counts), stick + traits_.backlash_counts);
  double u = play_ - traits_.trim_counts;
  u = std::abs(u) > traits_.dead_zone_counts ? u - std::copysign(traits_.dead_zone_counts, u) : 0.0;
  if (traits_.exponent != 1.0) {
    u = std::copysign(660.0 * std::pow(std::abs(u) / 660.0, traits_.exponent), u);
  }
  u *= 2.0 * (u > 0.0 ? traits_.asymmetry : 1.0) / (1.0 + traits_.asymmetry);
  u += traits_.cross * arrived(sticks.other, now);
  const double drift = 1.0 + traits_.drift_per_minute * static_cast<double>(now) * kUnseenLogStep_s / 60.0;
  return std::clamp(traits_.gain * u * drift, -traits_.saturation, traits_.saturation);
}

double UnseenLogVehicle::step(const UnseenLogSticks& sticks, std::size_t now) {
  constexpr double kZeroFilter_s = 0.005;
  const double before = angle_;
  double a = command(sticks, now);
  if (traits_.lead_s > 0.0) {
    const double slope = (a - filtered_) / kZeroFilter_s;
    filtered_ += kUnseenLogStep_s * slope;
    a += traits_.lead_s * slope;
  }
  lagged_ = traits_.lag_s > 0.0 ? lagged_ + (a - lagged_) * (1.0 - std::exp(-kUnseenLogStep_s / traits_.lag_s)) : a;
  const double pull = traits_.spring_per_s * std::max(0.0, flown_m_ - traits_.tether_m);
  const double w = traits_.frequency_rad_s;
  const auto accel = [&](double y, double v) { return w * w * (lagged_ - pull - y) - 2.0 * traits_.damping * w * v; };
  const double a1 = accel(angle_, rate_);
  const double a2 = accel(angle_ + kUnseenLogStep_s * rate_, rate_ + kUnseenLogStep_s * a1);
  const double angle = angle_ + 0.5 * kUnseenLogStep_s * (2.0 * rate_ + kUnseenLogStep_s * a1);
  rate_ += 0.5 * kUnseenLogStep_s * (a1 + a2);
  angle_ = angle;
  if (std::abs(rate_) > traits_.rate_limit_per_s) {
    rate_ = std::copysign(traits_.rate_limit_per_s, rate_);
    angle_ = before + kUnseenLogStep_s * rate_;
  }
  flown_m_ += kUnseenLogStep_s * before;
  return before;
}

std::vector<double> response_of(const UnseenLogParameters& before, const UnseenLogParameters& after, double change_s,
                                const UnseenLogSticks& sticks) {
  std::vector<double> out(sticks.own.size());
  UnseenLogVehicle vehicle(before);
  bool changed = false;
  for (std::size_t k = 0; k < out.size(); ++k) {
    if (!changed && static_cast<double>(k) * kUnseenLogStep_s >= change_s) {
      vehicle.set_parameters(after);
      changed = true;
    }
    out[k] = vehicle.step(sticks, k);
  }
  return out;
}

UnseenLogPilot::UnseenLogPilot(UnseenLogInput hand, double reach, double feedback, UnseenLogRandom& rng)
    : hand_(hand), reach_(reach), feedback_(feedback), chance_(rng) {
  constexpr int kLines = 6;
  for (int k = 0; k < kLines; ++k) {
    hz_.push_back(std::exp(rng.between(std::log(0.06), std::log(2.0))));
    phase_.push_back(rng.between(0.0, 2.0 * std::numbers::pi));
  }
}

void UnseenLogPilot::go_on_with_doublet(double t_s) {
  if (half_ == 0.0) {
    half_ = chance_.between(0.15, 0.9);
    target_ = first_ = chance_.sign() * reach_ * chance_.between(0.6, 1.6);
    next_s_ = t_s + half_;
  } else if (first_ != 0.0) {  // the second half of the doublet
    target_ = -first_;
    next_s_ = t_s + half_;
    first_ = 0.0;
  } else {  // a pause
    target_ = 0.0;
    next_s_ = t_s + chance_.between(0.3, 1.5);
    half_ = 0.0;
  }
}

double UnseenLogPilot::target_of(double t_s) {
  if (t_s < next_s_) {
    return target_;
  }
  switch (hand_) {
    case UnseenLogInput::kDoublets:
      go_on_with_doublet(t_s);
      break;
    case UnseenLogInput::kBangBang:
      target_ = (target_ > 0.0 ? -1.0 : 1.0) * reach_;
      next_s_ = t_s + chance_.between(0.3, 1.8);
      break;
    case UnseenLogInput::kHolds:
      target_ = chance_.one_in(4.0) ? 0.0 : 1.6 * reach_ * chance_.between(-1.0, 1.0);
      next_s_ = t_s + chance_.between(0.3, 2.5);
      break;
    default:
      target_ = chance_.one_in(5.0) ? 0.0 : 1.2 * reach_ * chance_.normal();
      next_s_ = t_s + 0.12 + std::abs(chance_.normal()) * 0.6;
  }
  return target_;
}

double UnseenLogPilot::next(double t_s, double seen) {
  constexpr double kFullStick = 660.0;
  if (hand_ == UnseenLogInput::kSines) {
    stick_ = 0.0;
    for (std::size_t k = 0; k < hz_.size(); ++k) {
      stick_ += 0.55 * reach_ * std::sin(2.0 * std::numbers::pi * hz_[k] * t_s + phase_[k]);
    }
  } else {
    const bool smooth = hand_ == UnseenLogInput::kPilot || hand_ == UnseenLogInput::kLoop;
    const double wanted = target_of(t_s) - (hand_ == UnseenLogInput::kLoop ? feedback_ * seen : 0.0);
    stick_ = smooth ? stick_ + (wanted - stick_) * (1.0 - std::exp(-kUnseenLogStep_s / 0.1)) : wanted;
  }
  return std::clamp(stick_, -kFullStick, kFullStick);
}

}  // namespace m100::host_tests
