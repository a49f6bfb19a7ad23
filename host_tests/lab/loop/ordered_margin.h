// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/companion/files/text/json.h"
#include "host_tests/lab/gains/tuning/tune.h"

namespace m100::lab::loop {

// A law whose model has too short a delay is faster than its margins allow, and its error in flight may be smaller for
// that reason alone. Two laws are therefore compared at the same margin on the same aircraft.

/// The margins that a law must keep: the project's, or those that the law of the first vehicle file has on its own
/// model, where they are weaker. So a file that was tuned with weaker margins is not made slower.
struct MarginOrder {
  double peak_sensitivity = gains::kLargestPeakSensitivity;
  double delay_margin_s = gains::kFieldDelayMargin_s;
};
MarginOrder order_of(const model::Vehicle& first);

/// A vehicle file whose law keeps the ordered margins on an aircraft, if any input weight does.
struct OrderedLaw {
  model::Vehicle vehicle;
  bool keeps = false;  ///< false: no input weight does; `vehicle` has the least peak of the stable ones, if any is
};

/// `believed` with the smallest input weight, from its own upwards, whose law keeps the ordered margins on the aircraft
/// `truth`. Everything else stays.
OrderedLaw at_ordered_margin(const model::Vehicle& believed, const model::Vehicle& truth, const MarginOrder& order);

/// Whether the law of `believed` keeps the order on `truth`.
bool keeps_ordered_margin(const model::Vehicle& believed, const model::Vehicle& truth, const MarginOrder& order);

/// {"x": {"peak_sensitivity", "delay_margin_s", "gain_margin", "phase_margin_rad", "stable"}, "y": {...},
///  "ordered": whether the ordered margins are kept}: the law of `believed` on `truth`, as flown on Virtual RC.
Json margins_on(const model::Vehicle& believed, const model::Vehicle& truth, const MarginOrder& order);

}  // namespace m100::lab::loop
