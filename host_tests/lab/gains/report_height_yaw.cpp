// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/gains/report_height_yaw.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>
#include <functional>
#include <numbers>
#include <numeric>
#include <utility>
#include <vector>

#include "firmware/ctl/law/altitude_pid.h"
#include "firmware/est/filter/acceleration_history.h"
#include "firmware/est/filter/command_history.h"
#include "firmware/est/filter/height_filter.h"
#include "host_tests/lab/gains/margins.h"

namespace m100::lab::gains {
namespace {

using Complex = std::complex<double>;
constexpr double kOld_s = 0.03;                  ///< 20 ms of age of the pose, and half a tick before and after the law
constexpr double kMinGain = 1.9952623149688795;  // 6 dB
constexpr double kMinPhase_rad = 0.25 * std::numbers::pi;

/// The yaw axis' response at s, including its delay and the age of the pose.
Complex axis_at(const model::StickAxis& axis, Complex s) {
  const double w = axis.natural_frequency_rad_s;
  const Complex lag =
      axis.is_first_order() ? 1.0 + axis.time_constant_s * s : 1.0 + 2.0 * axis.damping_ratio * s / w + s * s / (w * w);
  return (1.0 + axis.lead_zero_s * s) / lag * std::exp(-s * (axis.transport_delay_s + kOld_s));
}

/// The yaw loop, continuous about rest, without its observer.
Margins yaw_margins(double proportional_per_s, const model::StickAxis& axis, double gain, const LoopTiming& timing) {
  const double period_s = 0.01 * static_cast<double>(timing.command_ticks);
  return margins_from(
      [&](double w) {
        const Complex s(0.0, w);
        const Complex hold = (1.0 - std::exp(-s * period_s)) / (s * period_s);
        return -gain * proportional_per_s * hold * axis_at(axis, s) / s;
      },
      period_s);
}

constexpr double kSmall = 1e-6;  ///< of a climb command [m/s]: no limit is reached
/// In this time the height filter's covariance settles, and the second difference of a response vanishes.
constexpr std::size_t kSettles_ticks = 6000;

/// The height loop with the filter and the law of the flight code, for `believed`.
struct HeightLoop {
  HeightLoop(const model::Vehicle& vehicle, const LoopTiming& loop_timing)
      : believed(vehicle),
        timing(loop_timing),
        steady(vehicle.climb, model::flown_noise(vehicle).pose_position_sigma_m) {
    for (std::size_t tick = 0; tick < kSettles_ticks; ++tick) {
      steady.fuse_pose(steady.test_pose(0.0, age_s, 0.0, 0.0));
      steady.predict({});
    }
  }
  /// From what the law sends in each command period after the vehicle, which really climbs as `climb`, got kSmall for
  /// the first period. The filter is told what the law sends, the vehicle gets no more: the loop is open at its
  /// command.
  Margins margins(const model::StickAxis& climb, double gain) const {
    model::Vehicle truth = believed;
    truth.climb = climb;
    est::HeightFilter<double> filter = steady, vehicle(climb, 1.0);  // the vehicle only predicts
    est::CommandHistory<double> told(believed), given(truth);
    ctl::AltitudePid<double> law(believed.altitude.design ? ctl::design_altitude(believed.climb, believed.altitude)
                                                          : believed.altitude);
    std::vector<double> heights(timing.pose_age_ticks, 0.0), response;
    for (std::size_t tick = 0; tick < kSettles_ticks; ++tick) {
      heights.push_back(vehicle.state(vehicle.kZ));
      filter.fuse_pose(filter.test_pose(heights[tick], age_s, 0.0, 0.0));
      const double commanded = law.update({}, filter.state(filter.kZ), filter.state(filter.kClimb), est::kTick_s);
      if (tick % timing.command_ticks == 0) {
        response.push_back(commanded);
      }
      told.store({.climb_m_s = response.back()}, {});
      given.store({.climb_m_s = tick < timing.command_ticks ? kSmall : 0.0}, {});
      filter.predict(told.climb());
      vehicle.predict(given.climb());
    }
    for (int difference = 0; difference < 2; ++difference) {  // it has two poles at 1
      std::adjacent_difference(response.begin(), response.end(), response.begin());
    }
    while (response.size() > 1 && std::abs(response.back()) < 1e-7 * kSmall) {
      response.pop_back();
    }
    const double period_s = est::kTick_s * static_cast<double>(timing.command_ticks);
    return margins_from(
        [&](double w) {
          const Complex back = std::polar(1.0, -w * period_s);
          Complex sum;
          for (auto value = response.rbegin(); value != response.rend(); ++value) {
            sum = sum * back + *value;
          }
          return gain * sum / (kSmall * (1.0 - back) * (1.0 - back));
        },
        period_s);
  }

  model::Vehicle believed;
  LoopTiming timing;
  double age_s = std::min(static_cast<double>(timing.pose_age_ticks) * est::kTick_s, est::kMaxPoseAge_s);
  est::HeightFilter<double> steady;
};

using MarginsAt = std::function<Margins(const model::StickAxis& truth, double gain)>;

/// The worst where gain and frequency (or 1 / time constant) are 20 % off, the damping 0.1 and the delay 10 ms.
Margins worst_corner(const MarginsAt& margins_at, const model::StickAxis& axis) {
  Margins worst{.stable = true, .gain_margin = 1e9, .phase_margin_rad = std::numbers::pi, .delay_margin_s = 1e9};
  for (int corner = 0; corner < 36; ++corner) {
    constexpr double kTwentyPercent[] = {0.8, 1.0, 1.2};
    const double frequency = kTwentyPercent[corner / 4 % 3];
    model::StickAxis one = axis;
    one.natural_frequency_rad_s *= frequency;
    one.time_constant_s /= frequency;
    one.damping_ratio = std::max(0.01, one.damping_ratio + (corner % 2 > 0 ? 0.1 : -0.1));  // keeps the axis stable
    one.transport_delay_s = std::max(0.0, one.transport_delay_s + (corner / 2 % 2 > 0 ? 0.01 : -0.01));
    const Margins margins = margins_at(one, kTwentyPercent[corner / 12]);
    worst.stable = worst.stable && margins.stable;
    worst.peak_sensitivity = std::max(worst.peak_sensitivity, margins.peak_sensitivity);
    worst.gain_margin = std::min(worst.gain_margin, margins.gain_margin);
    worst.phase_margin_rad = std::min(worst.phase_margin_rad, margins.phase_margin_rad);
    worst.delay_margin_s = std::min(worst.delay_margin_s, margins.delay_margin_s);
  }
  return worst;
}

Json to_json(const Margins& of) {
  return {{"stable", of.stable},
          {"peak_sensitivity", of.peak_sensitivity},
          {"gain_margin", of.gain_margin},
          {"phase_margin_rad", of.phase_margin_rad},
          {"delay_margin_s", of.delay_margin_s},
          {"kept", of.stable && of.gain_margin >= kMinGain && of.phase_margin_rad >= kMinPhase_rad}};
}

void print(const char* name, const LoopTiming& timing, const char* where, const Margins& of) {
  std::printf("%s, %s, %s: %speak sensitivity %.2f, gain margin %.1f dB, phase margin %.0f deg\n", name,
              words(timing).c_str(), where, of.stable ? "" : "UNSTABLE, ", of.peak_sensitivity,
              20.0 * std::log10(of.gain_margin), of.phase_margin_rad * 57.29577951);
}

}  // namespace

Json report_height_yaw(const model::Vehicle& vehicle) {
  Json out;
  for (const auto& one : {std::pair{"virtual_rc", &kVirtualRcTiming}, {"movement", &kMovementTiming}}) {
    const char* const channel = one.first;
    const LoopTiming* const timing = one.second;
    const auto add = [&](const char* name, const model::StickAxis& axis, const MarginsAt& margins_at) {
      const Margins nominal = margins_at(axis, 1.0);
      const Margins worst = worst_corner(margins_at, axis);
      print(name, *timing, "as the vehicle file", nominal);
      print(name, *timing, "worst corner", worst);
      out[name][channel] = to_json(nominal);
      out[name][channel]["corners"] = to_json(worst);
    };
    if (vehicle.climb.is_identified()) {
      const HeightLoop loop(vehicle, *timing);
      add("height", vehicle.climb, [&](const auto& truth, double gain) { return loop.margins(truth, gain); });
    }
    if (vehicle.yaw_rate.is_identified()) {
      add("yaw", vehicle.yaw_rate, [&](const auto& truth, double gain) {
        return yaw_margins(vehicle.yaw.proportional_per_s, truth, gain, *timing);
      });
    }
  }
  return out;
}

}  // namespace m100::lab::gains
