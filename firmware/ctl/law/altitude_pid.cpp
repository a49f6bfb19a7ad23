// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/ctl/law/altitude_pid.h"

namespace m100::ctl {
namespace {

// Natural frequency times delay; with kDamping it leaves 6 dB of gain margin in every corner (`m100-lab gains`).
constexpr double kBandwidth = 0.42;
constexpr double kDamping = 1.02;
constexpr double kFeedback_s = 0.03;  // delay by pose age, tick and stick period, which no vehicle file states
constexpr double kSlowest_rad_s = 1.0;
constexpr double kFastest_rad_s = 4.0;
constexpr double kIntegralShare = 0.1;  // integral corner over natural frequency

}  // namespace

model::AltitudeGains design_altitude(const model::StickAxis& climb, const model::AltitudeGains& base) {
  const bool second = !(climb.time_constant_s > 0.0) && climb.natural_frequency_rad_s > 0.0;
  const double lag_s = second ? 2.0 * climb.damping_ratio / climb.natural_frequency_rad_s
                              : (climb.time_constant_s > 0.05 ? climb.time_constant_s : 0.05);
  const double rest_s = second ? 0.5 / climb.natural_frequency_rad_s : 0.0;
  const double late_s = climb.transport_delay_s + rest_s + kFeedback_s;
  const double frequency = core::clamp(kBandwidth / late_s, kSlowest_rad_s, kFastest_rad_s);
  model::AltitudeGains gains = base;
  gains.proportional_per_s = frequency * frequency * lag_s;
  const double derivative = 2.0 * kDamping * frequency * lag_s - 1.0;
  if (derivative > 0.0) {
    gains.derivative = derivative;
  } else {  // the climb loop alone damps enough
    gains.derivative = 0.0;
    gains.proportional_per_s = 0.25 / (kDamping * kDamping * lag_s);
  }
  gains.integral_per_s2 = kIntegralShare * frequency * gains.proportional_per_s;
  return gains;
}

}  // namespace m100::ctl
