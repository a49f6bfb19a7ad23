// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/gains/margins.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>

namespace m100::lab::gains {

std::string words(const LoopTiming& timing) {
  return std::string(timing.by_sticks ? "virtual_rc" : "movement") + " at " +
         std::to_string(100 / timing.command_ticks) + " Hz, pose " + std::to_string(10 * timing.pose_age_ticks) +
         " ms old";
}

Margins margins_from(const std::function<std::complex<double>(double)>& response, double period_s, int frequencies) {
  Margins out;
  out.gain_margin = std::numeric_limits<double>::infinity();
  out.phase_margin_rad = std::numbers::pi;
  out.delay_margin_s = std::numeric_limits<double>::infinity();
  const double low = std::log(0.02);
  const double high = std::log(std::numbers::pi / period_s);
  std::complex<double> before;
  double before_frequency = 0.0;
  double angle = 0.0;  // of 1 + L; it begins at minus a right angle for each pole at 0
  for (int i = 0; i <= frequencies; ++i) {
    const double frequency = std::exp(low + (high - low) * i / frequencies);
    const std::complex<double> gain = -response(frequency);  // L: the loop is closed by -1
    out.peak_sensitivity = std::max(out.peak_sensitivity, 1.0 / std::abs(1.0 + gain));
    angle += i > 0 ? std::arg((1.0 + gain) / (1.0 + before)) : std::arg(-1.0 - gain) - std::numbers::pi;
    if (i > 0 && (std::abs(before) - 1.0) * (std::abs(gain) - 1.0) <= 0.0) {
      // phase above -180 degrees, in [0, 2 pi): the lag that a delay must reach
      const double at = frequency * (std::abs(before) > 1.0 ? std::sqrt(before_frequency / frequency) : 1.0);
      double phase = std::arg(-gain);
      out.phase_margin_rad = std::min(out.phase_margin_rad, std::abs(phase));
      phase = phase < 0.0 ? phase + 2.0 * std::numbers::pi : phase;
      out.delay_margin_s = std::min(out.delay_margin_s, phase / at);
      out.crossover_rad_s = at;
    }
    if (i > 0 && before.imag() * gain.imag() <= 0.0 && gain.real() < 0.0 && std::abs(gain) < 1.0) {
      out.gain_margin = std::min(out.gain_margin, 1.0 / std::abs(gain));
    }
    before = gain;
    before_frequency = frequency;
  }
  out.stable = std::abs(angle) < 0.5 * std::numbers::pi;
  return out;
}

}  // namespace m100::lab::gains
