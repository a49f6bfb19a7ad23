// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/property/identify/unseen_log_pilot.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace m100::host_tests {

std::vector<double> response_of(const oracle::AxisParameters& before, const oracle::AxisParameters& after,
                                double change_s, const UnseenLogSticks& sticks) {
  std::vector<double> out(sticks.own.size());
  oracle::AxisVehicle vehicle(before, kUnseenLogStep_s);
  bool changed = false;
  for (std::size_t k = 0; k < out.size(); ++k) {
    if (!changed && static_cast<double>(k) * kUnseenLogStep_s >= change_s) {
      vehicle.set_parameters(after);
      changed = true;
    }
    out[k] = vehicle.step(sticks.own[k], sticks.other[k]);
  }
  return out;
}

UnseenLogPilot::UnseenLogPilot(UnseenLogInput hand, double reach, double feedback, oracle::Random& rng)
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
