// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/model/translation_effect.h"

namespace m100::model::translation {

/// A constant acceleration that turns with the vehicle: forward, and to the left.
struct BodyBias {
  static Acceleration column(std::size_t which, const Moment& at, double) {
    return which == 0 ? Acceleration{at.heading_cosine, at.heading_sine, 0.0}
                      : Acceleration{-at.heading_sine, at.heading_cosine, 0.0};
  }

  static constexpr TranslationEffect kEffect{
      .name = "body_bias",
      .place = 20,
      .parameters = {{{.name = "accel_x_m_s2", .low = -kMaxAcceleration_m_s2, .high = kMaxAcceleration_m_s2},
                      {.name = "accel_y_m_s2", .low = -kMaxAcceleration_m_s2, .high = kMaxAcceleration_m_s2}}},
      .min_relevant = 0.06,
      .size = length_of_two,
      .columns = 2,
      .column = column,
      .equivalent = "steady_wind",
      .change = {.name = "body_bias", .unit = "accel_m_s2", .min_relevant = 0.15},
      .in_flight = InFlight::kLeftToTheObserver,
      .sentence = "A constant acceleration that turns with the vehicle: an unbalance or a sensor bias, not wind.",
      .not_in_file = "has no place in the vehicle file: trim the vehicle; the observer carries it"};
};

}  // namespace m100::model::translation
