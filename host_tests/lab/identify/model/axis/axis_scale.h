// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/model/axis_effect.h"
#include "host_tests/lab/identify/model/axis/axis_blocks.h"

namespace m100::lab::identify {

/// Typical sizes in the training data, so that starts and bounds suit any unit and any aircraft.
struct AxisScale {
  double stick = 1.0;           ///< 98 % of the sticks are closer to `centre` [counts]
  double gain = 1.0;            ///< first guess, unit per count
  double response = 1.0;        ///< 98 % of the measured values are smaller in size
  double rate_per_s = 1.0;      ///< 99 % of the slopes over six samples are smaller in size
  double minimum_counts = 1.0;  ///< 1; if `stick` is at most 5 (no counts, but commands or fractions), 1/660
  double centre = 0.0;          ///< stick at which a straight line through the data answers nothing [counts]
  double of(model::AxisNumber::FitUnit unit) const;
  /// Converts a number from the unit of fits, where a trim counts from `centre`, so that no fit depends on the neutral
  /// of the column map.
  double physical(const model::AxisNumber& number, double in_unit) const;
  double in_unit(const model::AxisNumber& number, double physical) const;

 private:
  double origin(const model::AxisNumber& number) const;
};
/// Precondition: at least one block.
AxisScale scale_of(const AxisBlocks& training);

}  // namespace m100::lab::identify
