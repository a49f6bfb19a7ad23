// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "host_tests/lab/logs/flight_log.h"
#include "host_tests/oracle/axis_vehicle.h"
#include "host_tests/oracle/random.h"

namespace m100::oracle {

/// Small, medium and large size of an effect.
struct SyntheticSizes {
  std::string_view effect;
  std::array<double, 3> sizes;
  double negative_factor = 1.0;  ///< factor for the half of the vehicles that have it in the opposite direction
  bool is_ratio = false;         ///< the sizes are logarithms
};
inline constexpr std::array kSyntheticSizes{
    SyntheticSizes{"transport_delay", {0.04, 0.1, 0.18}},
    SyntheticSizes{"lead_zero", {0.06, 0.12, 0.2}},
    SyntheticSizes{"dead_zone", {14.0, 26.0, 50.0}},
    SyntheticSizes{"dead_zone_jump", {14.0, 26.0, 50.0}},
    SyntheticSizes{"trim_offset", {18.0, 45.0, 90.0}, -1.0},
    SyntheticSizes{"backlash", {12.0, 24.0, 45.0}},
    SyntheticSizes{"saturation", {0.28, 0.22, 0.16}},
    SyntheticSizes{"tilt_limit", {0.33, 0.27, 0.2}},
    SyntheticSizes{"rate_limit", {1.2, 0.9, 0.6}},
    SyntheticSizes{"gain_asymmetry", {0.12, 0.25, 0.5}, -1.0, true},
    SyntheticSizes{"stick_curve", {0.12, 0.3, 0.5}, -0.7, true},
    SyntheticSizes{"gain_drift", {0.12, 0.25, 0.45}, -1.0},
    SyntheticSizes{"cross_axis", {0.06, 0.15, 0.3}, -1.0},
    SyntheticSizes{"sine", {0.006, 0.015, 0.03}},
    SyntheticSizes{"input_product", {0.2, 0.5, 1.0}, -1.0},
    SyntheticSizes{"command_dropout", {0.06, 0.12, 0.25}},  // per second
};

/// Logs of one roll axis (axis_vehicle.h at 1 kHz), with sticks as a pilot moves them and moving air. Hidden effects
/// are given by name and size; see random_size().
struct SyntheticAxis {
  double duration_s = 45.0;
  double gain_rad = 8.5e-4;
  double natural_frequency_rad_s = 8.5;
  double damping_ratio = 0.68;
  double delay_s = 0.02;
  double air_rad = 0.004;  ///< standard deviation of the coloured disturbance
  double air_time_s = 0.4;
  double sensor_rad = 0.002;
  bool first_order = false;
  std::map<std::string, double> hidden;
  /// Hidden effects after change_s, instead of those above. In addition: "gain" and "frequency" (factors),
  /// "transport_delay" [s] and "air" (factor of the disturbance).
  double change_s = 1e9;
  std::map<std::string, double> hidden_later;
  std::uint64_t seed = 1;

  lab::logs::FlightLog fly() const {
    const auto size = static_cast<std::size_t>(duration_s / kPeriod_s);
    Random random(seed);
    const std::vector<double> roll = hand(size, random);
    const std::vector<double> pitch = hand(size, random);
    const std::vector<double> arriving = received(roll, random);
    lab::logs::FlightLog log;
    log.file = "synthetic";
    log.size = size;
    log.gap.assign(size, 0);
    log.of(lab::logs::Signal::kAttitudeRoll) = seen(response_to(arriving, pitch), random);
    log.of(lab::logs::Signal::kStickRoll) = rounded(roll);
    log.of(lab::logs::Signal::kStickPitch) = rounded(pitch);
    return log;
  }

  /// Random vehicle, air and pilot; the caller adds `hidden`.
  static SyntheticAxis random(std::uint64_t seed) {
    Random random(seed * 7919 + 17);
    SyntheticAxis out;
    out.seed = seed;
    out.gain_rad = 7.5e-4 + 2e-4 * random.between(0.0, 1.0);
    out.natural_frequency_rad_s = 6.5 + 4.0 * random.between(0.0, 1.0);
    out.damping_ratio = 0.55 + 0.3 * random.between(0.0, 1.0);
    out.delay_s = 0.01 + 0.02 * random.between(0.0, 1.0);
    out.air_rad = 0.003 + 0.002 * random.between(0.0, 1.0);
    out.air_time_s = 0.2 + 0.5 * random.between(0.0, 1.0);
    return out;
  }

  /// Size of an effect: 0 small, 1 medium, 2 large, with a random variation of +-15 %.
  static double random_size(const std::string& effect, int size, std::uint64_t seed) {
    Random random(seed * 104729 + 5);
    const double chance = 0.85 + 0.3 * random.between(0.0, 1.0);
    const double sign = random.between(0.0, 1.0) < 0.5 ? -1.0 : 1.0;
    if (effect == "sine_hz") {
      return 0.3 + 1.2 * random.between(0.0, 1.0);
    }
    const auto row = std::find_if(kSyntheticSizes.begin(), kSyntheticSizes.end(),
                                  [&](const SyntheticSizes& one) { return effect == one.effect; });
    if (row == kSyntheticSizes.end()) {
      return 0.0;
    }
    const double value =
        (sign > 0.0 ? 1.0 : row->negative_factor) * chance * row->sizes.at(static_cast<std::size_t>(size));
    return row->is_ratio ? std::exp(value) : value;
  }

 private:
  static constexpr double kPeriod_s = 0.01;

  /// The effects that are active at one time.
  struct Effects {
    const std::map<std::string, double>& sizes;
    bool has(const char* effect) const { return sizes.count(effect) > 0; }
    double size_of(const char* effect, double otherwise) const {
      const auto found = sizes.find(effect);
      return found == sizes.end() ? otherwise : found->second;
    }
  };
  Effects effects_at(double t_s) const { return {t_s < change_s ? hidden : hidden_later}; }

  /// The stick as received, with occasional lost commands: the last one is held.
  std::vector<double> received(const std::vector<double>& stick, Random& random) const {
    std::vector<double> out = stick;
    double lost_until_s = -1.0;
    double held = 0.0;
    for (std::size_t i = 0; i < stick.size(); ++i) {
      const double t_s = static_cast<double>(i) * kPeriod_s;
      const Effects effects = effects_at(t_s);
      if (!effects.has("command_dropout")) {
        continue;
      }
      if (t_s > lost_until_s && random.between(0.0, 1.0) < effects.size_of("command_dropout", 0.0) * kPeriod_s) {
        lost_until_s = t_s + 0.3 + 0.7 * random.between(0.0, 1.0);
      }
      held = t_s < lost_until_s ? held : stick[i];
      out[i] = held;
    }
    return out;
  }

  AxisParameters parameters_with(const std::map<std::string, double>& effects) const {
    AxisParameters out{.gain = gain_rad,
                       .frequency_rad_s = natural_frequency_rad_s,
                       .damping = damping_ratio,
                       .first_order = first_order,
                       .delay_s = delay_s};
    for (const auto& [name, size] : effects) {
      set_effect(out, name, size);
    }
    return out;
  }

  /// @returns the angle at every sample.
  std::vector<double> response_to(const std::vector<double>& roll, const std::vector<double>& pitch) const {
    constexpr int kSub = 10;
    AxisVehicle vehicle(parameters_with(hidden), kPeriod_s / kSub);
    std::vector<double> out(roll.size());
    bool changed = false;
    for (std::size_t i = 0; i < roll.size(); ++i) {
      if (!changed && static_cast<double>(i) * kPeriod_s >= change_s) {
        AxisParameters later = parameters_with(hidden_later);
        later.lead_s = parameters_with(hidden).lead_s;  // lead zero and rate limit never change
        later.rate_limit_per_s = parameters_with(hidden).rate_limit_per_s;
        vehicle.set_parameters(later);
        changed = true;
      }
      out[i] = vehicle.response();
      for (int sub = 0; sub < kSub; ++sub) {
        vehicle.step(roll[i], pitch[i]);
      }
    }
    return out;
  }

  /// Adds the disturbance by the air and the sensor's noise.
  std::vector<double> seen(std::vector<double> angle, Random& random) const {
    random.drop_pair();
    GaussMarkovNoise air(air_rad, air_time_s, kPeriod_s);
    air.start(random);
    for (std::size_t i = 0; i < angle.size(); ++i) {
      const double t_s = static_cast<double>(i) * kPeriod_s;
      const Effects effects = effects_at(t_s);
      const double sine =
          effects.size_of("sine", 0.0) * std::sin(2.0 * M_PI * effects.size_of("sine_hz", 0.7) * t_s + 1.0);
      angle[i] = angle[i] + effects.size_of("air", 1.0) * air.value() + sine + sensor_rad * random.normal();
      air.step(random);
    }
    return angle;
  }

  // Held targets with smooth transitions, like a pilot's.
  static std::vector<double> hand(std::size_t size, Random& random) {
    random.drop_pair();
    std::vector<double> out(size);
    double target = 0.0;
    double value = 0.0;
    std::size_t next = 100;
    for (std::size_t i = 0; i < size; ++i) {
      if (i >= next) {
        target = random.between(0.0, 1.0) < 0.15 ? 0.0 : std::clamp(190.0 * random.normal(), -520.0, 520.0);
        next = i + static_cast<std::size_t>(30.0 + 120.0 * random.between(0.0, 1.0));
      }
      value += (target - value) * (1.0 - std::exp(-0.01 / 0.08));
      out[i] = value;
    }
    return out;
  }
  static std::vector<double> rounded(std::vector<double> values) {
    for (double& value : values) {
      value = std::round(value);
    }
    return values;
  }
};

}  // namespace m100::oracle
