// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/model/axis_effect.h"
#include "host_tests/lab/identify/model/axis/axis_blocks.h"

namespace m100::lab::identify {

/// Typical sizes in the training data, so that starts and bounds suit any unit and any aircraft.
struct AxisScale {
  double stick = 1.0;           ///< 98 % of the sticks are smaller in size [counts]
  double gain = 1.0;            ///< first guess, unit per count
  double response = 1.0;        ///< 98 % of the measured values are smaller in size
  double rate_per_s = 1.0;      ///< 99 % of the slopes over six samples are smaller in size
  double minimum_counts = 1.0;  ///< 1; if `stick` is at most 5 (no counts, but commands or fractions), 1/660
  double of(model::AxisNumber::FitUnit unit) const;
};
/// Precondition: at least one block.
AxisScale scale_of(const AxisBlocks& training);

}  // namespace m100::lab::identify
