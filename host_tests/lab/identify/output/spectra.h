// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <complex>
#include <cstddef>
#include <utility>
#include <vector>

namespace m100::lab::identify {

// Spectra and correlations of residuals and responses, for the report. A series has one value per sample; it may join
// several stretches of a log, one after the other.

/// Ranges of consecutive samples [first, last) without a gap: t_s increases by one sample period from each to the next.
std::vector<std::pair<std::size_t, std::size_t>> stretches(const std::vector<double>& t_s, double sample_period_s);

/// Power densities and cross density of two series by Welch's method: segments of about 5 s (a power of two of samples)
/// that overlap by half, each about its mean and under a Hann window. Densities are one-sided, unit squared per Hz.
struct Spectra {
  std::vector<double> frequency_hz;  ///< without zero; empty: no stretch is as long as a segment
  std::vector<double> input;
  std::vector<double> output;
  std::vector<std::complex<double>> cross;  ///< conjugate of the input times the output
  std::size_t segments = 0;

  /// Share of the output's power that follows the input linearly, 0 to 1; always 1 with fewer than two segments.
  /// @pre k < frequency_hz.size()
  double coherence(std::size_t k) const;
  /// Output over input at this frequency, output's unit per input's. @pre k < frequency_hz.size(); not a number where
  /// the input has no power.
  std::complex<double> response(std::size_t k) const { return cross[k] / input[k]; }
};
/// Both series are as long as the stretches reach. Cost: n log n.
Spectra welch(const std::vector<double>& input, const std::vector<double>& output,
              const std::vector<std::pair<std::size_t, std::size_t>>& stretches, double sample_period_s);

/// Correlation of `later[k + lag]` with `earlier[k]`, both about their means, over all pairs within one stretch.
double cross_correlation(const std::vector<double>& earlier, const std::vector<double>& later, std::ptrdiff_t lag,
                         const std::vector<std::pair<std::size_t, std::size_t>>& stretches);
/// Half width of the 95 % band of a cross-correlation of two independent coloured series (Bartlett): 1.96 times the
/// root of the summed products of their autocorrelations over the number of samples.
/// @param longest  lag up to which the autocorrelations are summed
double independent_band(const std::vector<double>& a, const std::vector<double>& b, std::size_t longest,
                        const std::vector<std::pair<std::size_t, std::size_t>>& stretches);

}  // namespace m100::lab::identify
