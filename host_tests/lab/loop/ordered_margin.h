// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "host_tests/lab/gains/tune.h"

namespace m100::lab::loop {

// A law whose model has too short a delay is faster than ordered, and its error in flight may be smaller for that
// alone. Two laws are therefore compared at the same margin on the same aircraft.

/// A vehicle file whose law keeps the ordered margins on an aircraft, if any input weight does.
struct OrderedLaw {
  model::Vehicle vehicle;
  bool keeps = false;  ///< false: no input weight keeps them; the one with the least peak sensitivity
};

/// `believed` with the smallest input weight, from its own upwards, whose law keeps gains::kLargestPeakSensitivity and
/// gains::kFieldDelayMargin_s on an aircraft that really is `truth`. Everything else stays.
OrderedLaw at_ordered_margin(const model::Vehicle& believed, const model::Vehicle& truth);

/// Whether the law of `believed` keeps the ordered margins on `truth`.
bool keeps_ordered_margin(const model::Vehicle& believed, const model::Vehicle& truth);

/// {"x": {"peak_sensitivity", "delay_margin_s", "gain_margin", "phase_margin_rad", "stable", ...}, "y": {...},
///  "ordered": whether the ordered margins are kept}: the law of `believed` on `truth`, as flown on Virtual RC.
nlohmann::json margins_on(const model::Vehicle& believed, const model::Vehicle& truth);

}  // namespace m100::lab::loop
