// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <deque>
#include <set>
#include <string>

#include "host_tests/lab/hidden/hidden_flight.h"

namespace m100::lab::hidden {

inline constexpr double kStep_s = 0.002;
inline constexpr double kTravel_counts = 330.0;

/// The effects that can act on a stick between hand and actuator. Hidden effects that it does not know are ignored.
class StickPath {
 public:
  StickPath(const HiddenEffects& hidden, double delay_s)
      : hidden_(hidden), line_(static_cast<std::size_t>(std::lround(delay_s / kStep_s)) + 1, 0.0), other_line_(line_) {}

  /// Whether this effect of the library is simulated, by this class or by Tilt, which receives its output.
  static bool supports(const std::string& effect) {
    static const std::set<std::string> kKnown{"transport_delay", "lead_zero",      "dead_zone",   "saturation",
                                              "rate_limit",      "gain_asymmetry", "trim_offset", "stick_curve",
                                              "backlash",        "gain_drift",     "cross_axis"};
    return kKnown.count(effect) > 0;
  }
  /// @param other the other stick [counts]. @returns effective counts.
  double pass(double stick, double other, double now_s) {
    line_.push_back(stick);
    double u = line_.front();
    line_.pop_front();
    other_line_.push_back(other);
    const double late_other = other_line_.front();
    other_line_.pop_front();
    const double late_stick = u;
    u -= value("trim_offset");
    if (const double half = value("backlash"); half > 0.0) {
      play_ = std::clamp(play_, u - half, u + half);
      u = play_;
    }
    if (const double width = value("dead_zone"); width > 0.0) {
      u = std::abs(u) <= width ? 0.0 : u - std::copysign(width, u);
    }
    if (std::abs(u) <= value("dead_zone_jump")) {
      u = 0.0;
    }
    if (const double exponent = value("stick_curve"); exponent > 0.0) {
      u = std::copysign(kTravel_counts * std::pow(std::abs(u) / kTravel_counts, exponent), u);
    }
    if (const double ratio = value("gain_asymmetry"); ratio > 0.0 && u > 0.0) {
      u *= ratio;
    }
    u *= 1.0 + value("gain_drift") * now_s / 60.0;
    u += value("cross_axis") * late_other;
    u += 0.5 * value("product") * late_stick * late_other / kTravel_counts;
    return u;
  }

 private:
  double value(const char* name) const { return value_of(hidden_, name); }

  const HiddenEffects& hidden_;
  std::deque<double> line_;
  std::deque<double> other_line_;
  double play_ = 0.0;
};

/// Response to a scaled stick, with limits: first order if time_constant_s > 0, else second order with a lead zero.
struct Tilt {
  double scale_rad, frequency_rad_s, damping;
  double time_constant_s = 0.0;
  double angle = 0.0, rate = 0.0, input = 0.0;

  void step(double target, double zero_s, double rate_limit, double limit) {
    const double slope = (target - input) / kStep_s;
    input = target;
    double wanted = target;
    if (limit > 0.0) {
      wanted = std::clamp(wanted, -limit, limit);
    }
    if (time_constant_s > 0.0) {
      const double slew = (wanted - angle) / time_constant_s;
      rate = rate_limit > 0.0 ? std::clamp(slew, -rate_limit, rate_limit) : slew;
      angle += kStep_s * rate;
      return;
    }
    const double lead = zero_s > 0.0 ? zero_s * slope : 0.0;
    rate +=
        kStep_s * (frequency_rad_s * frequency_rad_s * (wanted + lead - angle) - 2 * damping * frequency_rad_s * rate);
    if (rate_limit > 0.0) {
      rate = std::clamp(rate, -rate_limit, rate_limit);
    }
    angle += kStep_s * rate;
  }
};

}  // namespace m100::lab::hidden
