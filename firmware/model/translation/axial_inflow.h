// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/model/translation_effect.h"

namespace m100::model::translation {

/// Thrust falls with the vehicle's speed through the air along the rotors' axis: a = -i (b3 . v) b3.
struct AxialInflow {
  static Acceleration column(std::size_t, const Moment& at, double) {
    const auto& v = at.air_velocity_w_m_s;
    const auto& up = at.up_b_in_w;
    const double along = up[0] * v[0] + up[1] * v[1] + up[2] * v[2];
    return {-along * up[0], -along * up[1], -along * up[2]};
  }

  static constexpr TranslationEffect kEffect{
      .name = "axial_inflow",
      .place = 80,
      .needs = {.velocity = true, .thrust_set_point = true},
      .parameters = {{{.name = "coefficient_per_s", .low = 0.0, .high = 20.0}}},
      .min_relevant = 0.03,
      .columns = 1,
      .column = column,
      .acts = Acts::kInThrust,
      .in_flight = InFlight::kNowhere,
      .sentence = "Thrust falls while climbing and rises while sinking: the height loop damps it.",
      .not_in_file = "has no place in the vehicle file: the height loop hides it"};
};

}  // namespace m100::model::translation
