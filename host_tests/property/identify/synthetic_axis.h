// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "host_tests/lab/identify/model/axis/axis_blocks.h"
#include "host_tests/lab/logs/flight_log.h"

namespace m100::host_tests {

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

/// Simulates one roll axis without sharing code with the tested one: fourth-order Runge-Kutta at 1 kHz, sticks as a
/// pilot moves them, moving air. Hidden effects are given by name and size; see random_size().
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
  double calm_from_s = 1e9;  ///< from then on the pilot moves both sticks by calm_share only
  double calm_share = 1.0;
  double level_counts = 0.0;     ///< both sticks take multiples of this only; 0: any value
  std::size_t held_samples = 1;  ///< for which both sticks hold each value
  std::uint64_t seed = 1;

  lab::logs::FlightLog fly() const {
    const auto size = static_cast<std::size_t>(duration_s / kPeriod_s);
    std::mt19937_64 random(seed);
    const std::vector<double> roll = moved(hand(size, random));
    const std::vector<double> pitch = moved(hand(size, random));
    const std::vector<double> command = commands(roll, pitch, random);
    lab::logs::FlightLog log;
    log.file = "synthetic";
    log.size = size;
    log.gap.assign(size, 0);
    log.of(lab::logs::Signal::kAttitudeRoll) = seen(answers(command), random);
    log.of(lab::logs::Signal::kStickRoll) = rounded(roll);
    log.of(lab::logs::Signal::kStickPitch) = rounded(pitch);
    return log;
  }

  /// Random vehicle, air and pilot; the caller adds `hidden`.
  static SyntheticAxis random(std::uint64_t seed) {
    std::mt19937_64 random(seed * 7919 + 17);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    SyntheticAxis out;
    out.seed = seed;
    out.gain_rad = 7.5e-4 + 2e-4 * uniform(random);
    out.natural_frequency_rad_s = 6.5 + 4.0 * uniform(random);
    out.damping_ratio = 0.55 + 0.3 * uniform(random);
    out.delay_s = 0.01 + 0.02 * uniform(random);
    out.air_rad = 0.003 + 0.002 * uniform(random);
    out.air_time_s = 0.2 + 0.5 * uniform(random);
    return out;
  }

  /// Size of an effect: 0 small, 1 medium, 2 large, with a random variation of +-15 %.
  static double random_size(const std::string& effect, int size, std::uint64_t seed) {
    std::mt19937_64 random(seed * 104729 + 5);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    const double chance = 0.85 + 0.3 * uniform(random);
    const double sign = uniform(random) < 0.5 ? -1.0 : 1.0;
    if (effect == "sine_hz") {
      return 0.3 + 1.2 * uniform(random);
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
  std::vector<double> received(const std::vector<double>& stick, std::mt19937_64& random) const {
    std::vector<double> out = stick;
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    double lost_until_s = -1.0;
    double held = 0.0;
    for (std::size_t i = 0; i < stick.size(); ++i) {
      const double t_s = static_cast<double>(i) * kPeriod_s;
      const Effects effects = effects_at(t_s);
      if (!effects.has("command_dropout")) {
        continue;
      }
      if (t_s > lost_until_s && uniform(random) < effects.size_of("command_dropout", 0.0) * kPeriod_s) {
        lost_until_s = t_s + 0.3 + 0.7 * uniform(random);
      }
      held = t_s < lost_until_s ? held : stick[i];
      out[i] = held;
    }
    return out;
  }

  /// Applies trim, dead zones and curve, in counts.
  static double shaped(const Effects& effects, double counts) {
    double u = counts - effects.size_of("trim_offset", 0.0);
    const double width = effects.size_of("dead_zone", 0.0);
    u = std::abs(u) <= width ? 0.0 : u - std::copysign(width, u);
    if (effects.has("dead_zone_jump")) {
      u = std::abs(u) <= effects.size_of("dead_zone_jump", 0.0) ? 0.0 : u;
    }
    return std::copysign(660.0 * std::pow(std::abs(u) / 660.0, effects.size_of("stick_curve", 1.0)), u);
  }

  /// Applies the limits, in rad.
  static double limited(const Effects& effects, double angle, double other) {
    const double tilt = std::hypot(angle, other);
    if (effects.has("tilt_limit") && tilt > effects.size_of("tilt_limit", 1.0)) {
      angle *= effects.size_of("tilt_limit", 1.0) / tilt;
    }
    return effects.has("saturation")
               ? std::clamp(angle, -effects.size_of("saturation", 1.0), effects.size_of("saturation", 1.0))
               : angle;
  }

  std::vector<double> commands(const std::vector<double>& roll, const std::vector<double>& pitch,
                               std::mt19937_64& random) const {
    const std::vector<double> stick = received(roll, random);
    std::vector<double> out(stick.size());
    double play = 0.0;
    for (std::size_t i = 0; i < stick.size(); ++i) {
      const double t_s = static_cast<double>(i) * kPeriod_s;
      const Effects effects = effects_at(t_s);
      const double half = effects.size_of("backlash", 0.0);
      const double ratio = effects.size_of("gain_asymmetry", 1.0);
      play = std::min(std::max(play, stick[i] - half), stick[i] + half);
      const double u = shaped(effects, play);
      double a = gain_rad * u * (u > 0.0 ? 2.0 * ratio / (1.0 + ratio) : 2.0 / (1.0 + ratio));
      a += gain_rad * effects.size_of("cross_axis", 0.0) * pitch[i];
      a += gain_rad * effects.size_of("input_product", 0.0) * roll[i] * pitch[i] / 660.0;
      a *= effects.size_of("gain", 1.0) * (1.0 + effects.size_of("gain_drift", 0.0) * t_s / 60.0);
      out[i] = limited(effects, a, gain_rad * pitch[i]);
    }
    return out;
  }

  struct Motion {
    double angle = 0.0;
    double rate = 0.0;
    double lagged = 0.0;  ///< state of a fast lag, which gives the derivative for a lead zero
  };

  /// One step of the dynamics with the natural frequency w towards a command. Lead zero and rate limit never change.
  void advance(Motion& motion, double command, double w, double h) const {
    const double limit = effects_at(0.0).size_of("rate_limit", 1e9);
    motion.lagged += (command - motion.lagged) * (1.0 - std::exp(-h / 0.004));
    const double a = command + effects_at(0.0).size_of("lead_zero", 0.0) * (command - motion.lagged) / 0.004;
    const double y = motion.angle, v = motion.rate;
    if (first_order) {
      motion.angle += h * std::clamp(w * (a - y), -limit, limit);
      return;
    }
    const auto accel = [&](double yy, double vv) { return w * w * (a - yy) - 2.0 * damping_ratio * w * vv; };
    const double k1y = v, k1v = accel(y, v);
    const double k2y = v + 0.5 * h * k1v, k2v = accel(y + 0.5 * h * k1y, v + 0.5 * h * k1v);
    const double k3y = v + 0.5 * h * k2v, k3v = accel(y + 0.5 * h * k2y, v + 0.5 * h * k2v);
    const double k4y = v + h * k3v, k4v = accel(y + h * k3y, v + h * k3v);
    motion.angle += h / 6.0 * (k1y + 2.0 * k2y + 2.0 * k3y + k4y);
    motion.rate += h / 6.0 * (k1v + 2.0 * k2v + 2.0 * k3v + k4v);
    if (std::abs(motion.rate) > limit) {
      motion.rate = std::copysign(limit, motion.rate);
      motion.angle = y + h * motion.rate;
    }
  }

  /// @returns the angle at every sample.
  std::vector<double> answers(const std::vector<double>& command) const {
    constexpr int kSub = 10;
    const double h = kPeriod_s / kSub;
    const auto last = static_cast<double>(command.size() - 1);
    std::vector<double> out(command.size());
    Motion motion;
    for (std::size_t i = 0; i < command.size(); ++i) {
      const Effects effects = effects_at(static_cast<double>(i) * kPeriod_s);
      const double dead_time_s = delay_s + effects.size_of("transport_delay", 0.0);
      const double w = natural_frequency_rad_s * effects.size_of("frequency", 1.0);
      out[i] = motion.angle;
      for (int sub = 0; sub < kSub; ++sub) {
        const double t_s = static_cast<double>(i) * kPeriod_s + sub * h;
        const double index = std::floor((t_s - dead_time_s) / kPeriod_s + 1e-9);
        advance(motion, command[static_cast<std::size_t>(std::clamp(index, 0.0, last))], w, h);
      }
    }
    return out;
  }

  /// Adds the disturbance by the air and the sensor's noise.
  std::vector<double> seen(std::vector<double> angle, std::mt19937_64& random) const {
    std::normal_distribution<double> normal;
    const double keep = std::exp(-kPeriod_s / air_time_s);
    double air = air_rad * normal(random);
    for (std::size_t i = 0; i < angle.size(); ++i) {
      const double t_s = static_cast<double>(i) * kPeriod_s;
      const Effects effects = effects_at(t_s);
      const double sine =
          effects.size_of("sine", 0.0) * std::sin(2.0 * M_PI * effects.size_of("sine_hz", 0.7) * t_s + 1.0);
      angle[i] = angle[i] + effects.size_of("air", 1.0) * air + sine + sensor_rad * normal(random);
      air = keep * air + air_rad * std::sqrt(1.0 - keep * keep) * normal(random);
    }
    return angle;
  }

  // Held targets with smooth transitions, like a pilot's.
  static std::vector<double> hand(std::size_t size, std::mt19937_64& random) {
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    std::normal_distribution<double> normal;
    std::vector<double> out(size);
    double target = 0.0;
    double value = 0.0;
    std::size_t next = 100;
    for (std::size_t i = 0; i < size; ++i) {
      if (i >= next) {
        target = uniform(random) < 0.15 ? 0.0 : std::clamp(190.0 * normal(random), -520.0, 520.0);
        next = i + static_cast<std::size_t>(30.0 + 120.0 * uniform(random));
      }
      value += (target - value) * (1.0 - std::exp(-0.01 / 0.08));
      out[i] = value;
    }
    return out;
  }
  /// The sticks as the pilot or a program moves them.
  std::vector<double> moved(std::vector<double> stick) const {
    for (std::size_t i = 0; i < stick.size(); ++i) {
      const double value = stick[i / held_samples * held_samples];
      stick[i] = level_counts > 0.0 ? level_counts * std::round(value / level_counts) : value;
      stick[i] *= static_cast<double>(i) * kPeriod_s < calm_from_s ? 1.0 : calm_share;
    }
    return stick;
  }
  static std::vector<double> rounded(std::vector<double> values) {
    for (double& value : values) {
      value = std::round(value);
    }
    return values;
  }
};

}  // namespace m100::host_tests
