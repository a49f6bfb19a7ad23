// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/model/translation_effect.h"

namespace m100::model::translation {

/// Thrust differs from its set point T by a factor: a = gain T b3.
struct ThrustGain {
  double thrust_gain = 1.0;
  static constexpr std::array<double ThrustGain::*, 1> kMembers{&ThrustGain::thrust_gain};

  static Acceleration column(std::size_t, const Moment& at, double) { return at.thrust_w_m_s2; }

  static constexpr TranslationEffect kEffect{
      .name = "thrust_gain",
      .place = 60,
      .needs = {.thrust_set_point = true},
      .parameters = {{{.name = "gain", .low = 0.3, .high = 3.0, .neutral = 1.0, .key = "thrust_gain"}}},
      .min_relevant = 0.01,
      .size = distance_from_one,
      .columns = 1,
      .column = column,
      .acts = Acts::kInThrust,
      .report = report_gain,
      .change = {.name = "mass", .unit = "thrust_over_mass", .min_relevant = 0.03},
      .in_flight = InFlight::kNowhere,
      .sentence = "Thrust is not what the set point says: the height loop sees it first."};
};

}  // namespace m100::model::translation
