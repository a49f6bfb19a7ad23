// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/model/translation_effect.h"

namespace m100::model::translation {

/// Thrust follows its set point with a lag of first order.
struct ThrustLag {
  double thrust_lag_s = 0.0;
  static constexpr std::array<double ThrustLag::*, 1> kMembers{&ThrustLag::thrust_lag_s};

  static void reshape(const ThrustSeries& series, double lag_s) {
    if (!(lag_s > 0.0)) {
      return;
    }
    const double share = 1.0 - core::exp(-series.period_s / lag_s);
    double before = series.thrust_m_s2.empty() ? 0.0 : series.thrust_m_s2[0];
    for (std::size_t i = 1; i < series.thrust_m_s2.size(); ++i) {
      // The set point between two samples is their mean: exact to second order for a slow input.
      const double set_point = series.thrust_m_s2[i];
      const double last = series.thrust_m_s2[i - 1];
      series.thrust_m_s2[i] = last + share * (0.5 * (set_point + before) - last);
      before = set_point;
    }
  }

  static constexpr TranslationEffect kEffect{
      .name = "thrust_lag",
      .place = 70,
      .needs = {.thrust_set_point = true},
      .parameters = {{{.name = "lag_s", .low = 0.0, .high = 1.0, .key = "thrust_lag_s"}}},
      .min_relevant = 0.012,
      .acts = Acts::kInThrust,
      .searched = {{{.low = 0.0,
                     .high = 0.5,
                     .first_step = 0.02,
                     .last_step = 0.01,
                     .repeated_step = 0.005,
                     .turn = 10,
                     .values = {0.01, 0.04, 0.1, 0.2},
                     .value_count = 4}}},
      .reshape = reshape,
      .report = report_searched,
      .in_flight = InFlight::kNowhere,
      .sentence = "Thrust follows late: the height loop has less margin."};
};

}  // namespace m100::model::translation
