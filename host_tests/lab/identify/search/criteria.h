// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "host_tests/lab/identify/search/selection.h"

namespace m100::lab::identify {

// What an edit of a model is worth: cross validation and two information criteria.

/// Fills everything but the fit. Folds are interleaved blocks.
void cross_validate(const Family& family, Judged& judged, std::size_t folds);
/// Fits `structure` to everything and cross-validates it.
Judged judge(const Family& family, const Structure& structure, const Fit* warm, std::size_t folds);

/// Number of independent samples that a coloured residual is worth: n / (1 + 2 sum of autocorrelations), the sum cut
/// at its first non-positive term. Blocks are correlated within, not across; they may differ in length.
double effective_sample_size(const std::vector<std::vector<double>>& blocks);

/// The same criterion on whitened residuals, `without` minus `with` an effect of `extra` parameters: means over 50 ms,
/// filtered by the autoregression of order 4 that whitens `with`. Slow air hides fast effects (a lead zero) from the
/// criterion on the effective sample size; it does not hide them from this one. Both hold the same blocks, sample by
/// sample. @returns 0 where no block is long enough to be whitened.
double whitened_criterion(const std::vector<std::vector<double>>& without, const std::vector<std::vector<double>>& with,
                          std::size_t extra);

/// n_eff ln(mean square) + k ln(n_eff)
double information_criterion(double mean_square, double effective_samples, std::size_t parameters);

/// Two structures set against each other.
struct Comparison {
  double cv_gain = 0.0;
  double delta_bic = 0.0;
  double delta_white = 0.0;
  double t = 0.0;
  /// Share of the fit's error beyond the starts of the blocks that it removes. A block that begins while the stick
  /// jumps begins in a wrong state, and what mends that (a rate limit, beside a lead zero) is nothing of the vehicle.
  double gain_beyond_starts = 0.0;
};

/// Both criteria on the effective sample size of the better-explained residual: the one without the effect is coloured
/// by the very effect that is asked about. `samples`: of all training blocks together. Precondition: both are
/// cross-validated over the same blocks.
/// @param start  samples of each block in which its start shows
Comparison compare(const Judged& without, const Judged& with, double samples, std::size_t start);

/// Whether that is enough to believe the effect, its physical size apart.
bool convincing(const Comparison& comparison, const SelectionOptions& options);

}  // namespace m100::lab::identify
