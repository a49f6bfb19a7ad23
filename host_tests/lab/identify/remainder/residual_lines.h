// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

namespace m100::lab::identify {

// Two patterns that no regression on causes sees: a fast line (vibration) and a slow drift.

struct FastLine {
  double hz = 0.0;
  double share = 0.0;  ///< of the power of the whole residual
  double peak = 0.0;   ///< over the mean of its neighbourhood
};

/// Strongest line between 4 Hz and 0.45 of the sample rate: periodograms of 5 s pieces, averaged. Above what the
/// thinned residual can show, where a line would appear under a false frequency. Cost: linear in samples.
/// @param row_s  between the log's own rows, where it was resampled from slower ones: what lies above is its own making
FastLine fast_line(const std::vector<double>& residual, double period_s, double row_s = 0.0);

struct Drift {
  double share = 0.0;  ///< of the power of the residual that a straight line over time takes
  double t = 0.0;      ///< of its slope
};

/// A straight line through the means of blocks. Air forgets within a second: means over 2.5 s are independent of each
/// other, so the slope's t says whether the aircraft (or its sensor) wanders.
Drift drift(const std::vector<double>& residual, const std::vector<std::size_t>& block_begin,
            const std::vector<double>& time_s);

}  // namespace m100::lab::identify
