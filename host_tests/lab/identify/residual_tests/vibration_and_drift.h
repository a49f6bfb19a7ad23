// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

namespace m100::lab::identify {

// Two patterns that a regression on causes does not show: a high-frequency peak (vibration) and a slow drift.

/// The bins with which a spectral peak is compared.
struct Neighbourhood {
  std::size_t first = 0;   ///< the lowest bin
  std::size_t around = 0;  ///< bins on both sides of the peak
  std::size_t own = 0;     ///< bins on both sides that belong to the peak
};

/// Ratio of a spectral peak to the mean power around it; 0 where there is no power.
double height_of(const std::vector<double>& power, std::size_t bin, const Neighbourhood& place);

struct SpectralLine {
  double hz = 0.0;
  double share = 0.0;  ///< of the power of the whole residual
  double peak = 0.0;   ///< over the mean of its neighbourhood
};

/// Strongest spectral peak between 4 Hz and 0.45 of the sample rate, from averaged periodograms of 5 s pieces. The
/// residual must not be thinned, or the peak would be aliased. Cost: linear in samples.
/// @param row_s  time between the log's own rows, if it was resampled from slower ones: peaks above 0.45 / row_s come
///   from the resampling and are not searched
SpectralLine vibration_peak(const std::vector<double>& residual, double period_s, double row_s = 0.0);

struct Drift {
  double share = 0.0;  ///< of the power of the residual that a straight line over time takes
  double t = 0.0;      ///< Student's t of its slope, at least 0
};

/// Fits a straight line through the means of blocks. Air is correlated over about a second, so means over 2.5 s are
/// independent of each other, and the slope's t shows whether the aircraft (or its sensor) drifts.
Drift drift(const std::vector<double>& residual, const std::vector<std::size_t>& block_begin,
            const std::vector<double>& time_s);

}  // namespace m100::lab::identify
