// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/body/rotor_mixer.h"

#include <algorithm>
#include <cmath>

namespace m100::sim {
namespace {

constexpr RotorNumbers kRoll{-1.0, 1.0, 1.0, -1.0};
constexpr RotorNumbers kPitch{-1.0, 1.0, -1.0, 1.0};
constexpr RotorNumbers kYaw{-1.0, -1.0, 1.0, 1.0};
constexpr double kRange = 1.0 - RotorMixer::kIdle;

double range_of(const RotorNumbers& rotors) {
  const auto [low, high] = std::minmax_element(rotors.begin(), rotors.end());
  return *high - *low;
}

}  // namespace

RotorNumbers RotorMixer::mix(const RotorDemand& demand) {
  RotorNumbers tilt{};
  for (std::size_t i = 0; i < tilt.size(); ++i) {
    tilt[i] = demand.roll * kRoll[i] + demand.pitch * kPitch[i];
  }
  const double wanted = range_of(tilt);
  const double kept = wanted > kRange ? kRange / wanted : 1.0;
  // Yaw adds at most twice its size to the range.
  const double room = std::max(0.0, 0.5 * (kRange - kept * wanted));
  const double yaw_limit = std::min(room, kMaxYaw * std::max(demand.collective, kIdle));
  const double yaw = std::clamp(demand.yaw, -yaw_limit, yaw_limit);
  for (std::size_t i = 0; i < tilt.size(); ++i) {
    tilt[i] = kept * tilt[i] + yaw * kYaw[i];
  }
  const auto [low, high] = std::minmax_element(tilt.begin(), tilt.end());
  const double collective = std::max(std::min(demand.collective, 1.0 - *high), kIdle - *low);
  RotorNumbers thrust{};
  for (std::size_t i = 0; i < tilt.size(); ++i) {
    thrust[i] = std::clamp(collective + tilt[i], kIdle, 1.0);
  }
  return thrust;
}

double throttle_of(double thrust, double curve) {
  const double linear = 1.0 - curve;
  return curve == 0.0 ? thrust : (std::sqrt(linear * linear + 4.0 * curve * thrust) - linear) / (2.0 * curve);
}

}  // namespace m100::sim
