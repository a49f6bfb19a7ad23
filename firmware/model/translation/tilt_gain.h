// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/model/translation_effect.h"

namespace m100::model::translation {

/// The horizontal acceleration of a tilt differs by a factor from what its angle implies: gain T b3 in x and y.
struct TiltGain {
  double tilt_gain = 1.0;
  static constexpr std::array<double TiltGain::*, 1> kMembers{&TiltGain::tilt_gain};

  static Acceleration column(std::size_t, const Moment& at, double) {
    return {at.thrust_w_m_s2[0], at.thrust_w_m_s2[1], 0.0};
  }

  static constexpr TranslationEffect kEffect{
      .name = "tilt_gain",
      .place = 50,
      .needs = {.tilt_in_thrust = true},
      .parameters = {{{.name = "gain", .low = 0.3, .high = 3.0, .neutral = 1.0, .key = "tilt_gain"}}},
      .min_relevant = 0.03,
      .size = distance_from_one,
      .columns = 1,
      .column = column,
      .acts = Acts::kOnThrust,
      .report = report_gain,
      .change = {.name = "tilt_gain", .unit = "gain", .min_relevant = 0.05},
      .in_flight = InFlight::kInThePrediction,
      .sentence = "A tilt gives more or less acceleration than gravity says: scale or thrust compensation is off."};
};

}  // namespace m100::model::translation
