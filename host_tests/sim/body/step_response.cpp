// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/body/step_response.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <vector>

#include "host_tests/sim/body/take_off.h"

namespace m100::sim {
namespace {

constexpr core::Duration kSample = std::chrono::microseconds(2500);
constexpr double kSample_s = 0.0025;
constexpr double kStepTilt_rad = 0.1;
constexpr double kStepClimb_m_s = 0.5;
constexpr double kTilts_s = 1.0;
constexpr double kClimbs_s = 2.0;

struct Interval {
  double low;
  double high;
  double beyond(double value) const { return std::max({0.0, low - value, value - high}); }
};

/// What `m100-lab identify` finds in the measured flights (pitch_roll.csv, height.csv), with its 95 % intervals. The
/// response is fitted in the same structure: delay and lead zero are those found there.
struct Measured {
  const char* axis;
  Interval frequency_rad_s;
  Interval damping_ratio;
  double delay_s;
  double zero_s;
};
constexpr std::array kMeasured{Measured{"roll", {6.09, 8.59}, {0.719, 0.792}, 0.0552, 0.1104},
                               Measured{"pitch", {5.50, 6.94}, {0.685, 0.740}, 0.0553, 0.1493},
                               Measured{"climb", {5.60, 6.70}, {0.739, 1.127}, 0.0, 0.0}};

double error_of(const SecondOrder& model, std::span<const double> samples, double step_s, double delay_s,
                double zero_s) {
  // The lead zero adds the response's own rate: y = x + zero x', x the response without it.
  const double w = model.frequency_rad_s;
  double x = 0.0, rate = 0.0, sum = 0.0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double input = static_cast<double>(i) * step_s >= delay_s ? 1.0 : 0.0;
    rate += step_s * (w * w * (input - x) - 2.0 * model.damping_ratio * w * rate);
    x += step_s * rate;
    sum += std::pow(x + zero_s * rate - samples[i], 2);
  }
  return sum;
}

/// The axis' own quantity now, in the unit of its command.
double output(const VehicleState& state, std::size_t axis) {
  const core::Euler<double> attitude = core::euler_of(state.rotation_wb);
  return axis == 0 ? attitude.roll_rad : axis == 1 ? attitude.pitch_rad : state.velocity_w_m_s.z();
}

std::vector<double> step_of(VehiclePort& body, std::size_t axis) {
  const double size = axis == 2 ? kStepClimb_m_s : kStepTilt_rad;
  const core::Euler<double> hover = body.attitude();  // in wind, a tilt
  MovementInput input{.roll_rad = hover.roll_rad, .pitch_rad = hover.pitch_rad};
  (axis == 0 ? input.roll_rad : axis == 1 ? input.pitch_rad : input.climb_m_s) += size;
  const double before = output(body.state(), axis);
  std::vector<double> samples;
  for (double t_s = 0.0; t_s < (axis == 2 ? kClimbs_s : kTilts_s); t_s += kSample_s) {
    body.command(input);
    body.advance(kSample);
    samples.push_back((output(body.state(), axis) - before) / size);
  }
  return samples;
}

std::string sentence(const Measured& measured, const SecondOrder& found) {
  std::array<char, 200> text{};
  std::snprintf(text.data(), text.size(),
                "%s %.2f rad/s [%.2f, %.2f] beyond by %.2f, damping %.2f [%.2f, %.2f] beyond by %.2f", measured.axis,
                found.frequency_rad_s, measured.frequency_rad_s.low, measured.frequency_rad_s.high,
                measured.frequency_rad_s.beyond(found.frequency_rad_s), found.damping_ratio, measured.damping_ratio.low,
                measured.damping_ratio.high, measured.damping_ratio.beyond(found.damping_ratio));
  return text.data();
}

}  // namespace

SecondOrder fit_step(std::span<const double> samples, double step_s, double delay_s, double zero_s) {
  SecondOrder best{8.0, 0.8};
  double least = error_of(best, samples, step_s, delay_s, zero_s);
  // Pattern search on a logarithmic grid: each round halves the step where no neighbour is better.
  for (double factor = 1.5; factor > 1.001;) {
    const SecondOrder centre = best;
    for (const double w : {1.0 / factor, 1.0, factor}) {
      for (const double z : {1.0 / factor, 1.0, factor}) {
        const SecondOrder next{std::clamp(centre.frequency_rad_s * w, 0.5, 100.0),
                               std::clamp(centre.damping_ratio * z, 0.05, 5.0)};
        const double error = error_of(next, samples, step_s, delay_s, zero_s);
        if (error < least) {
          best = next;
          least = error;
        }
      }
    }
    if (best.frequency_rad_s == centre.frequency_rad_s && best.damping_ratio == centre.damping_ratio) {
      factor = std::sqrt(factor);
    }
  }
  return best;
}

std::string compare_response(VehiclePort& body, const core::Vector<double, 3>& place_w_m) {
  std::string out = "response of the body beside the measured aircraft [95 %]: ";
  for (std::size_t axis = 0; axis < kMeasured.size(); ++axis) {
    const std::vector<double> samples = step_of(body, axis);
    const Measured& measured = kMeasured[axis];
    out += sentence(measured, fit_step(samples, kSample_s, measured.delay_s, measured.zero_s)) +
           (axis + 1 < kMeasured.size() ? "; " : "");
    take_off(body, place_w_m);  // back to the place
  }
  return out;
}

}  // namespace m100::sim
