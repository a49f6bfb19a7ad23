// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/model/translation_effect.h"

namespace m100::model::translation {

/// Drag of the rotors: a = -k (v - w), w the wind.
struct LinearDrag {
  double linear_drag_per_s = 0.01;  ///< of the default vehicle; 0: without this drag
  static constexpr std::array<double LinearDrag::*, 1> kMembers{&LinearDrag::linear_drag_per_s};

  static Acceleration column(std::size_t, const Moment& at, double) {
    const auto& v = at.air_velocity_w_m_s;
    return {-v[0], -v[1], -v[2]};
  }

  static constexpr TranslationEffect kEffect{
      .name = "linear_drag",
      .place = 30,
      .needs = {.velocity = true},
      .parameters = {{{.name = "rate_per_s", .low = 0.0, .high = 5.0, .key = "linear_drag_per_s"}}},
      .min_relevant = 0.03,
      .columns = 1,
      .column = column,
      .drag = Drag::kProportional,
      .change = {.name = "linear_drag", .unit = "rate_per_s", .min_relevant = 0.05},
      .in_flight = InFlight::kInThePrediction,
      .sentence = "Drag grows with speed: the model damps the velocity by it."};
};

}  // namespace m100::model::translation
