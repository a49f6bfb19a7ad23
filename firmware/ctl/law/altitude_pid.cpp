// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/ctl/law/altitude_pid.h"

#include <algorithm>

namespace m100::ctl {
namespace {

// Natural frequency times delay. With kDamping, kIntegralShare and the noises of est/filter/height_filter.cpp it leaves
// 6 dB and 45 degrees in every corner (`m100-lab gains`).
constexpr double kBandwidth = 0.41;
constexpr double kDamping = 1.05;
constexpr double kFeedback_s = 0.03;  // delay by pose age and tick, which no vehicle file states
constexpr double kHold_s = 0.02;      // half of the stick period
// Largest Kd / T, and largest Kp where Kd is 0, times delay and hold: 6 dB and 45 degrees for T of 0.05 to 1 s.
constexpr double kMaxDerivative = 0.6;
constexpr double kMaxProportional = 0.45;
constexpr double kFastest_rad_s = 4.0;
constexpr double kIntegralShare = 0.08;  // integral corner over natural frequency

}  // namespace

model::AltitudeGains design_altitude(const model::StickAxis& climb, const model::AltitudeGains& base) {
  const bool second = !(climb.time_constant_s > 0.0) && climb.natural_frequency_rad_s > 0.0;
  const double lag_s = second ? 2.0 * climb.damping_ratio / climb.natural_frequency_rad_s
                              : (climb.time_constant_s > 0.05 ? climb.time_constant_s : 0.05);
  const double late_s = climb.transport_delay_s + (second ? 0.5 / climb.natural_frequency_rad_s : 0.0) + kFeedback_s;
  const double by_derivative = (1.0 / lag_s + kMaxDerivative / (late_s + kHold_s)) / (2.0 * kDamping);
  const double frequency = std::min({kBandwidth / late_s, by_derivative, kFastest_rad_s});
  model::AltitudeGains gains = base;
  gains.proportional_per_s = frequency * frequency * lag_s;
  gains.derivative = 2.0 * kDamping * frequency * lag_s - 1.0;
  if (gains.derivative < 0.0) {  // the climb loop alone damps enough
    gains.derivative = 0.0;
    gains.proportional_per_s = std::min(0.25 / (kDamping * kDamping * lag_s), kMaxProportional / (late_s + kHold_s));
  }
  gains.integral_per_s2 = kIntegralShare * frequency * gains.proportional_per_s;
  return gains;
}

}  // namespace m100::ctl
