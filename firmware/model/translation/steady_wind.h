// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/model/translation_effect.h"

namespace m100::model::translation {

/// A constant horizontal acceleration in the world frame. With a drag that grows faster than the speed, a search
/// finds the speed of the wind instead; the report still has the acceleration that this wind gives a vehicle at rest.
struct SteadyWind {
  static Acceleration column(std::size_t which, const Moment&, double) {
    return {which == 0 ? 1.0 : 0.0, which == 1 ? 1.0 : 0.0, 0.0};
  }
  static constexpr SearchedParameter kSpeedX{.low = -40.0,
                                             .high = 40.0,
                                             .first_step = 1.0,
                                             .last_step = 0.5,
                                             .repeated_step = 0.3,
                                             .turn = 40,
                                             .start = Start::kWindSpeed};
  static constexpr SearchedParameter kSpeedY{.low = -40.0,
                                             .high = 40.0,
                                             .first_step = 1.0,
                                             .last_step = 0.5,
                                             .repeated_step = 0.3,
                                             .turn = 41,
                                             .start = Start::kWindSpeed};

  static constexpr TranslationEffect kEffect{
      .name = "steady_wind",
      .place = 10,
      .parameters = {{{.name = "accel_x_m_s2", .low = -kMaxAcceleration_m_s2, .high = kMaxAcceleration_m_s2},
                      {.name = "accel_y_m_s2", .low = -kMaxAcceleration_m_s2, .high = kMaxAcceleration_m_s2}}},
      .min_relevant = 0.06,
      .size = length_of_two,
      .columns = 2,
      .column = column,
      .searched = {{kSpeedX, kSpeedY}},
      .equivalent = "body_bias",
      .change = {.name = "steady_wind", .unit = "accel_m_s2", .min_relevant = 0.15},
      .in_flight = InFlight::kLeftToTheObserver,
      .sentence = "A constant acceleration in the world: the observer carries it to the controller.",
      .not_in_file = "is the air of that flight: the observer estimates it in every flight anew"};
};

}  // namespace m100::model::translation
