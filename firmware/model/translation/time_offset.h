// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/model/translation_effect.h"

namespace m100::model::translation {

/// Thrust and attitude were logged on another clock than the motion: their values of offset_s earlier are used.
struct TimeOffset {
  static void take_earlier(std::span<double> values, std::span<double> old, double samples) {
    const std::size_t last = values.size() - 1;
    for (std::size_t i = 0; i <= last; ++i) {
      old[i] = values[i];
    }
    for (std::size_t i = 0; i <= last; ++i) {
      const double at = core::clamp(static_cast<double>(i) - samples, 0.0, static_cast<double>(last) - 1e-9);
      const auto k = static_cast<std::size_t>(at);
      const double share = at - static_cast<double>(k);
      values[i] = old[k] + share * (old[k < last ? k + 1 : last] - old[k]);
    }
  }
  static void reshape(const ThrustSeries& series, double offset_s) {
    if (offset_s == 0.0 || series.thrust_m_s2.size() < 2) {
      return;
    }
    const double samples = offset_s / series.period_s;
    take_earlier(series.thrust_m_s2, series.spare, samples);
    for (const std::span<double> axis : series.direction_w) {
      take_earlier(axis, series.spare, samples);
    }
  }

  static constexpr TranslationEffect kEffect{
      .name = "time_offset",
      .place = 100,
      .needs = {.tilt_in_thrust = true},
      .parameters = {{{.name = "offset_s", .low = -0.3, .high = 0.3}}},
      .min_relevant = 0.012,
      .size = magnitude,
      .acts = Acts::kInThrust,
      .searched = {{{.low = -0.3,
                     .high = 0.3,
                     .first_step = 0.02,
                     .last_step = 0.01,
                     .repeated_step = 0.005,
                     .turn = 20,
                     .values = {-0.1, -0.03, 0.03, 0.1},
                     .value_count = 4}}},
      .reshape = reshape,
      .report = report_searched,
      .in_flight = InFlight::kNowhere,
      .sentence = "The channels are shifted in time against each other: correct the log before all else.",
      .not_in_file = "belongs to the log, not to the vehicle"};
};

}  // namespace m100::model::translation
