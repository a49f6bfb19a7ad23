// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

#include "firmware/model/translation_effect.h"

namespace m100::model::translation {

/// A force with a period of its own: a fan that is switched, a gust that comes back.
struct PeriodicWind {
  /// The columns: cosine and sine along x, then along y.
  static Acceleration column(std::size_t which, const Moment& at, double frequency_hz) {
    const double turns = frequency_hz * at.time_s;
    const double phase = 2.0 * core::kPi * (turns - std::floor(turns));
    const double value = which % 2 == 0 ? core::cos(phase) : core::sin(phase);
    return {which < 2 ? value : 0.0, which < 2 ? 0.0 : value, 0.0};
  }
  static void report(std::span<const double> searched, std::span<const double> linear, std::span<double> out) {
    out[0] = searched[0];
    out[1] = length_of_two(linear.first(2));
    out[2] = length_of_two(linear.subspan(2));
  }
  static double size(std::span<const double> parameters) { return length_of_two(parameters.subspan(1)); }

  static constexpr TranslationEffect kEffect{
      .name = "periodic_wind",
      .place = 110,
      .parameters = {{{.name = "frequency_hz", .low = 0.02, .high = 10.0},
                      {.name = "amplitude_x_m_s2", .low = 0.0, .high = kMaxAcceleration_m_s2},
                      {.name = "amplitude_y_m_s2", .low = 0.0, .high = kMaxAcceleration_m_s2}}},
      .min_relevant = 0.05,
      .size = size,
      .columns = 4,
      .column = column,
      .searched = {{{.low = 0.02,
                     .high = 10.0,
                     .first_step = 0.005,
                     .last_step = 0.003,
                     .repeated_step = 0.002,
                     .turn = 30,
                     .start = Start::kStrongestPeak}}},
      .is_periodic = true,
      .report = report,
      .in_flight = InFlight::kLeftToTheObserver,
      .sentence = "A periodic force acts from outside: the observer follows it as far as its bandwidth goes.",
      .not_in_file = "is the air of that flight: the observer estimates it in every flight anew"};
};

}  // namespace m100::model::translation
