// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/model/translation_effect.h"

namespace m100::model::translation {

/// Drag of the body: a = -c |v - w| (v - w), w the wind.
struct QuadraticDrag {
  double quadratic_drag_per_m = 0.0;
  static constexpr std::array<double QuadraticDrag::*, 1> kMembers{&QuadraticDrag::quadratic_drag_per_m};

  static Acceleration column(std::size_t, const Moment& at, double) {
    const auto& v = at.air_velocity_w_m_s;
    const double speed = core::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    return {-speed * v[0], -speed * v[1], -speed * v[2]};
  }

  static constexpr TranslationEffect kEffect{
      .name = "quadratic_drag",
      .place = 40,
      .needs = {.velocity = true},
      .parameters = {{{.name = "coefficient_per_m", .low = 0.0, .high = 2.0, .key = "quadratic_drag_per_m"}}},
      .min_relevant = 0.008,
      .columns = 1,
      .column = column,
      .drag = Drag::kProgressive,
      .in_flight = InFlight::kInThePrediction,
      .sentence = "Drag grows with the square of speed: fast flight needs more tilt than the model says."};
};

}  // namespace m100::model::translation
