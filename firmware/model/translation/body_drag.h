// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/model/translation_effect.h"

namespace m100::model::translation {

/// Drag of a body that is not round: a = -diag(kx, ky) (v - w), along and across the heading, w the wind. None
/// vertically.
struct BodyDrag {
  double body_drag_x_per_s = 0.0;
  double body_drag_y_per_s = 0.0;
  static constexpr std::array<double BodyDrag::*, 2> kMembers{&BodyDrag::body_drag_x_per_s,
                                                              &BodyDrag::body_drag_y_per_s};

  static Acceleration column(std::size_t which, const Moment& at, double) {
    const double ahead[2] = {at.heading_cosine, at.heading_sine};
    const double aside[2] = {-at.heading_sine, at.heading_cosine};
    const auto& axis = which == 0 ? ahead : aside;
    const double speed = axis[0] * at.air_velocity_w_m_s[0] + axis[1] * at.air_velocity_w_m_s[1];
    return {-speed * axis[0], -speed * axis[1], 0.0};
  }

  static constexpr TranslationEffect kEffect{
      .name = "body_drag",
      .place = 130,
      .needs = {.velocity = true},
      .parameters = {{{.name = "x_per_s", .low = 0.0, .high = 5.0, .key = "body_drag_x_per_s", .only_if_set = true},
                      {.name = "y_per_s", .low = 0.0, .high = 5.0, .key = "body_drag_y_per_s", .only_if_set = true}}},
      .min_relevant = 0.03,
      .size = length_of_two,
      .columns = 2,
      .column = column,
      .drag = Drag::kProportional,
      .in_flight = InFlight::kLeftToTheObserver,
      .sentence = "Drag along the heading differs from drag across it: the observer carries what the turn changes."};
};

}  // namespace m100::model::translation
