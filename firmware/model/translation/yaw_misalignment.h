// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/model/translation_effect.h"

namespace m100::model::translation {

/// The heading of the attitude and that of the motion differ: the thrust is turned by an angle about the vertical.
struct YawMisalignment {
  static void reshape(const ThrustSeries& series, double angle_rad) {
    if (angle_rad == 0.0) {
      return;
    }
    const core::SinCos<double> turn = core::sin_cos_of(angle_rad);
    for (std::size_t i = 0; i < series.direction_w[0].size(); ++i) {
      const double x = series.direction_w[0][i];
      const double y = series.direction_w[1][i];
      series.direction_w[0][i] = turn.cosine * x - turn.sine * y;
      series.direction_w[1][i] = turn.sine * x + turn.cosine * y;
    }
  }

  static constexpr TranslationEffect kEffect{
      .name = "yaw_misalignment",
      .place = 90,
      .needs = {.tilt_in_thrust = true},
      .parameters = {{{.name = "angle_rad", .low = -1.0, .high = 1.0}}},
      .min_relevant = 0.03,
      .size = magnitude,
      .acts = Acts::kInThrust,
      .searched = {{{.low = -1.0,
                     .high = 1.0,
                     .first_step = 0.05,
                     .last_step = 0.02,
                     .repeated_step = 0.01,
                     .turn = 50,
                     .values = {-0.1, 0.1},
                     .value_count = 2}}},
      .reshape = reshape,
      .report = report_searched,
      .in_flight = InFlight::kNowhere,
      .sentence = "The two heading references differ by an angle: commands leave at that angle.",
      .not_in_file = "belongs to the log, not to the vehicle"};
};

}  // namespace m100::model::translation
