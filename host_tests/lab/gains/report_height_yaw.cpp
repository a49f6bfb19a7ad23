// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/gains/report_height_yaw.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <numbers>
#include <tuple>
#include <utility>
#include <vector>

#include "firmware/ctl/law/altitude_pid.h"
#include "host_tests/lab/gains/margins.h"

namespace m100::lab::gains {
namespace {

using Complex = std::complex<double>;
constexpr double kOld_s = 0.03;                  ///< 20 ms of age of the pose, and half a tick before and after the law
constexpr double kMinGain = 1.9952623149688795;  // 6 dB
constexpr double kMinPhase_rad = 0.25 * std::numbers::pi;

/// The axis' response at s, including its delay and the age of the pose.
Complex axis_at(const model::StickAxis& axis, Complex s) {
  const double w = axis.natural_frequency_rad_s;
  const Complex lag =
      axis.is_first_order() ? 1.0 + axis.time_constant_s * s : 1.0 + 2.0 * axis.damping_ratio * s / w + s * s / (w * w);
  return (1.0 + axis.lead_zero_s * s) / lag * std::exp(-s * (axis.transport_delay_s + kOld_s));
}

struct Loop {
  double proportional = 0.0, integral = 0.0, derivative = 0.0;
};

Margins margins_at(const Loop& loop, const model::StickAxis& axis, double gain, const LoopTiming& timing) {
  const double period_s = 0.01 * static_cast<double>(timing.command_ticks);
  return margins_from(
      [&](double w) {
        const Complex s(0.0, w);
        const Complex law = loop.proportional + loop.integral / s + loop.derivative * s;
        const Complex hold = (1.0 - std::exp(-s * period_s)) / (s * period_s);
        return -gain * law * hold * axis_at(axis, s) / s;
      },
      period_s);
}

/// Factors on gain and frequency (or on 1 / time constant) of an axis, and differences of its damping and delay.
struct Corner {
  double gain, frequency, damping, delay_s;
};

std::vector<Corner> corners() {
  std::vector<Corner> out;
  for (const double gain : {0.8, 1.0, 1.2}) {
    for (const double frequency : {0.8, 1.0, 1.2}) {
      for (const double damping : {-0.1, 0.1}) {
        out.push_back({gain, frequency, damping, -0.01});
        out.push_back({gain, frequency, damping, 0.01});
      }
    }
  }
  return out;
}

Margins worst_corner(const Loop& loop, const model::StickAxis& axis, const LoopTiming& timing) {
  Margins worst{.stable = true, .gain_margin = 1e9, .phase_margin_rad = std::numbers::pi, .delay_margin_s = 1e9};
  for (const Corner& corner : corners()) {
    model::StickAxis one = axis;
    one.natural_frequency_rad_s *= corner.frequency;
    one.time_constant_s /= corner.frequency;
    one.damping_ratio = std::max(0.01, one.damping_ratio + corner.damping);  // keeps the axis stable
    one.transport_delay_s = std::max(0.0, one.transport_delay_s + corner.delay_s);
    const Margins margins = margins_at(loop, one, corner.gain, timing);
    worst.stable = worst.stable && margins.stable;
    worst.peak_sensitivity = std::max(worst.peak_sensitivity, margins.peak_sensitivity);
    worst.gain_margin = std::min(worst.gain_margin, margins.gain_margin);
    worst.phase_margin_rad = std::min(worst.phase_margin_rad, margins.phase_margin_rad);
    worst.delay_margin_s = std::min(worst.delay_margin_s, margins.delay_margin_s);
  }
  return worst;
}

nlohmann::json to_json(const Margins& of) {
  return {{"stable", of.stable},
          {"peak_sensitivity", of.peak_sensitivity},
          {"gain_margin", of.gain_margin},
          {"phase_margin_rad", of.phase_margin_rad},
          {"delay_margin_s", of.delay_margin_s},
          {"kept", of.stable && of.gain_margin >= kMinGain && of.phase_margin_rad >= kMinPhase_rad}};
}

void print(const char* name, const char* channel, const char* where, const Margins& of) {
  std::printf("%s, %s, %s: %speak sensitivity %.2f, gain margin %.1f dB, phase margin %.0f deg\n", name, channel, where,
              of.stable ? "" : "UNSTABLE, ", of.peak_sensitivity, 20.0 * std::log10(of.gain_margin),
              of.phase_margin_rad * 57.29577951);
}

}  // namespace

nlohmann::json report_height_yaw(const model::Vehicle& vehicle) {
  const model::AltitudeGains height = ctl::design_altitude(vehicle.climb, vehicle.altitude);
  nlohmann::json out;
  for (const auto& [name, loop, axis] :
       {std::tuple{"height", Loop{height.proportional_per_s, height.integral_per_s2, height.derivative},
                   &vehicle.climb},
        {"yaw", Loop{vehicle.yaw.proportional_per_s, 0.0, 0.0}, &vehicle.yaw_rate}}) {
    if (!axis->is_identified()) {
      continue;
    }
    for (const auto& [channel, timing] : {std::pair{"virtual_rc", &kVirtualRcTiming}, {"movement", &kMovementTiming}}) {
      const Margins nominal = margins_at(loop, *axis, 1.0, *timing);
      const Margins worst = worst_corner(loop, *axis, *timing);
      print(name, channel, "as the vehicle file", nominal);
      print(name, channel, "worst corner", worst);
      out[name][channel] = to_json(nominal);
      out[name][channel]["corners"] = to_json(worst);
    }
  }
  return out;
}

}  // namespace m100::lab::gains
