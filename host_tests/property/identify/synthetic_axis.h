// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "host_tests/tools/identify/axis_blocks.h"
#include "host_tests/tools/logs/flight_log.h"

namespace m100::host_tests {

/// Flies one roll axis of a vehicle of its own, shares no code with what is tested: fourth-order Runge-Kutta at 1 kHz,
/// sticks as a hand moves them, air that is never still. Hidden effects by name, with their size; see random_size().
struct SyntheticAxis {
  double duration_s = 45.0;
  double gain_rad = 8.5e-4;
  double natural_frequency_rad_s = 8.5;
  double damping_ratio = 0.68;
  double delay_s = 0.02;
  double air_rad = 0.004;  ///< coloured disturbance, standard deviation
  double air_time_s = 0.4;
  double sensor_rad = 0.002;
  bool first_order = false;
  std::map<std::string, double> hidden;
  std::uint64_t seed = 1;

  tools::logs::FlightLog fly() const {
    constexpr double kPeriod_s = 0.01;
    constexpr int kSub = 10;
    const auto size = static_cast<std::size_t>(duration_s / kPeriod_s);
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    const std::vector<double> roll = hand(size, random);
    const std::vector<double> pitch = hand(size, random);
    const auto with = [&](const char* name) { return hidden.count(name) > 0; };
    const auto of = [&](const char* name, double otherwise) {
      const auto found = hidden.find(name);
      return found == hidden.end() ? otherwise : found->second;
    };

    std::vector<double> command(size);
    double play = 0.0;
    double dropped_until_s = -1.0;
    double held = 0.0;
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    for (std::size_t i = 0; i < size; ++i) {
      const double t_s = static_cast<double>(i) * kPeriod_s;
      double u = roll[i];
      if (with("command_dropout")) {
        if (t_s > dropped_until_s && uniform(random) < of("command_dropout", 0.0) * kPeriod_s) {
          dropped_until_s = t_s + 0.3 + 0.7 * uniform(random);
        }
        held = t_s < dropped_until_s ? held : u;
        u = held;
      }
      const double half = of("backlash", 0.0);
      play = std::min(std::max(play, u - half), u + half);
      u = play - of("trim_offset", 0.0);
      const double width = of("dead_zone", 0.0);
      u = std::abs(u) <= width ? 0.0 : u - std::copysign(width, u);
      if (with("dead_zone_jump")) {
        u = std::abs(u) <= of("dead_zone_jump", 0.0) ? 0.0 : u;
      }
      u = std::copysign(660.0 * std::pow(std::abs(u) / 660.0, of("stick_curve", 1.0)), u);
      const double ratio = of("gain_asymmetry", 1.0);
      double a = gain_rad * u * (u > 0.0 ? 2.0 * ratio / (1.0 + ratio) : 2.0 / (1.0 + ratio));
      a += gain_rad * of("cross_axis", 0.0) * pitch[i];
      a += gain_rad * of("input_product", 0.0) * roll[i] * pitch[i] / 660.0;
      a *= 1.0 + of("gain_drift", 0.0) * t_s / 60.0;
      const double other = gain_rad * pitch[i];
      const double tilt = std::hypot(a, other);
      if (with("tilt_limit") && tilt > of("tilt_limit", 1.0)) {
        a *= of("tilt_limit", 1.0) / tilt;
      }
      if (with("saturation")) {
        a = std::clamp(a, -of("saturation", 1.0), of("saturation", 1.0));
      }
      command[i] = a;
    }

    const double dead_time_s = delay_s + of("transport_delay", 0.0);
    const double lead_s = of("lead_zero", 0.0);
    const double limit = of("rate_limit", 1e9);
    const double w = natural_frequency_rad_s;
    const double z = damping_ratio;
    const auto at = [&](double t_s) {
      const double index = std::floor((t_s - dead_time_s) / kPeriod_s + 1e-9);
      return command[static_cast<std::size_t>(std::clamp(index, 0.0, static_cast<double>(size - 1)))];
    };
    double y = 0.0;
    double v = 0.0;
    double lagged = 0.0;  // a fast lag makes the derivative that a lead zero needs
    double air = air_rad * normal(random);
    std::vector<double> measured(size);
    for (std::size_t i = 0; i < size; ++i) {
      const double t0_s = static_cast<double>(i) * kPeriod_s;
      const double sine = of("sine", 0.0) * std::sin(2.0 * M_PI * of("sine_hz", 0.7) * t0_s + 1.0);
      measured[i] = y + air + sine + sensor_rad * normal(random);
      const double keep = std::exp(-kPeriod_s / air_time_s);
      air = keep * air + air_rad * std::sqrt(1.0 - keep * keep) * normal(random);
      for (int sub = 0; sub < kSub; ++sub) {
        const double h = kPeriod_s / kSub;
        const double raw = at(t0_s + sub * h);
        lagged += (raw - lagged) * (1.0 - std::exp(-h / 0.004));
        const double a = raw + lead_s * (raw - lagged) / 0.004;
        if (first_order) {
          const double slope = std::clamp(w * (a - y), -limit, limit);
          y += h * slope;
          continue;
        }
        const auto accel = [&](double yy, double vv) { return w * w * (a - yy) - 2.0 * z * w * vv; };
        const double k1y = v, k1v = accel(y, v);
        const double k2y = v + 0.5 * h * k1v, k2v = accel(y + 0.5 * h * k1y, v + 0.5 * h * k1v);
        const double k3y = v + 0.5 * h * k2v, k3v = accel(y + 0.5 * h * k2y, v + 0.5 * h * k2v);
        const double k4y = v + h * k3v, k4v = accel(y + h * k3y, v + h * k3v);
        const double before = y;
        y += h / 6.0 * (k1y + 2.0 * k2y + 2.0 * k3y + k4y);
        v += h / 6.0 * (k1v + 2.0 * k2v + 2.0 * k3v + k4v);
        if (std::abs(v) > limit) {
          v = std::copysign(limit, v);
          y = before + h * v;
        }
      }
    }
    tools::logs::FlightLog log;
    log.file = "synthetic";
    log.size = size;
    log.gap.assign(size, 0);
    log.of(tools::logs::Signal::kStickRoll) = rounded(roll);
    log.of(tools::logs::Signal::kStickPitch) = rounded(pitch);
    log.of(tools::logs::Signal::kAttitudeRoll) = measured;
    return log;
  }

  /// Random vehicle, air and hand; `hidden` is added by the caller.
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

  /// Size of an effect: 0 small, 1 medium, 2 large, with +-15 % of chance.
  static double random_size(const std::string& effect, int size, std::uint64_t seed) {
    std::mt19937_64 random(seed * 104729 + 5);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    const double chance = 0.85 + 0.3 * uniform(random);
    const double sign = uniform(random) < 0.5 ? -1.0 : 1.0;
    const auto pick = [&](double small, double medium, double large) {
      return size == 0 ? small : size == 1 ? medium : large;
    };
    const double x = chance;
    if (effect == "transport_delay") {
      return x * pick(0.04, 0.1, 0.18);
    }
    if (effect == "lead_zero") {
      return x * pick(0.06, 0.12, 0.2);
    }
    if (effect == "dead_zone" || effect == "dead_zone_jump") {
      return x * pick(14.0, 26.0, 50.0);
    }
    if (effect == "trim_offset") {
      return sign * x * pick(18.0, 45.0, 90.0);
    }
    if (effect == "backlash") {
      return x * pick(12.0, 24.0, 45.0);
    }
    if (effect == "saturation") {
      return x * pick(0.28, 0.22, 0.16);
    }
    if (effect == "tilt_limit") {
      return x * pick(0.33, 0.27, 0.2);
    }
    if (effect == "rate_limit") {
      return x * pick(1.2, 0.9, 0.6);
    }
    if (effect == "gain_asymmetry") {
      return std::exp(sign * x * pick(0.12, 0.25, 0.5));
    }
    if (effect == "stick_curve") {
      return std::exp((sign > 0.0 ? 1.0 : -0.7) * x * pick(0.12, 0.3, 0.5));
    }
    if (effect == "gain_drift") {
      return sign * x * pick(0.12, 0.25, 0.45);
    }
    if (effect == "cross_axis") {
      return sign * x * pick(0.06, 0.15, 0.3);
    }
    if (effect == "sine") {
      return x * pick(0.006, 0.015, 0.03);
    }
    if (effect == "sine_hz") {
      return 0.3 + 1.2 * uniform(random);
    }
    if (effect == "input_product") {
      return sign * x * pick(0.2, 0.5, 1.0);
    }
    if (effect == "command_dropout") {
      return x * pick(0.06, 0.12, 0.25);  // per second
    }
    return 0.0;
  }

 private:
  // Held targets, reached as a hand reaches them.
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
  static std::vector<double> rounded(std::vector<double> values) {
    for (double& value : values) {
      value = std::round(value);
    }
    return values;
  }
};

}  // namespace m100::host_tests
