// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "host_tests/lab/identify/selection/selection.h"

namespace m100::lab::identify {

// Judges edits of a model by cross-validation and two information criteria.

/// Fills all members of `validated` except its fit. Folds are interleaved blocks.
void cross_validate(const Family& family, CrossValidatedFit& validated, std::size_t folds);
/// Fits `structure` to all blocks and cross-validates it.
CrossValidatedFit cross_validated_fit(const Family& family, const Structure& structure, const Fit* warm,
                                      std::size_t folds);
/// Errors of all training blocks; each axis of a block is a series of its own, because no filter may run across axes.
std::vector<std::vector<double>> training_errors(const Family& family, const Fit& fit);

double samples_of(const std::vector<std::vector<double>>& blocks);
/// Sum of the products of samples that are `lag` apart in a block; zero where no block is longer.
double lagged_product(const std::vector<std::vector<double>>& blocks, std::size_t lag);

/// Number of independent samples that a coloured residual is worth: n / (1 + 2 sum of autocorrelations), the sum ending
/// before its first non-positive term. Samples are correlated within a block only; blocks may differ in length.
double effective_sample_size(const std::vector<std::vector<double>>& blocks);

/// By how much an effect of `extra` parameters lowers the information criterion on whitened residuals: means over five
/// samples (50 ms at 100 Hz), filtered by the autoregression of order 4 that whitens `with`. Slow air does not hide
/// fast effects (a lead zero) from this criterion. `without` and `with` the effect hold the errors of the same blocks.
/// @returns 0 if no block is long enough, or one fit is exact.
double whitened_criterion(const std::vector<std::vector<double>>& without, const std::vector<std::vector<double>>& with,
                          std::size_t extra);

/// n_eff ln(mean square) + k ln(n_eff)
double information_criterion(double mean_square, double effective_samples, std::size_t parameters);

struct Comparison {
  double cv_gain = 0.0;
  double delta_bic = 0.0;
  double delta_white = 0.0;
  double t = 0.0;
  /// Share that the edit removes of the fit's sum of squares, without the start of each block; 0 if cv_gain is not
  /// positive. A block that begins while the stick jumps starts from a wrong state; an edit that only corrects this is
  /// no effect of the vehicle.
  double gain_beyond_starts = 0.0;
};

/// Compares two cross-validated fits. The criteria use the effective sample size of the residual `with` the effect,
/// because the residual without it is coloured by this very effect. Precondition: both are of the same blocks.
/// @param samples  of all training blocks together
/// @param start  samples at the start of each block that depend on its initial state
Comparison compare(const CrossValidatedFit& without, const CrossValidatedFit& with, double samples, std::size_t start);

/// Whether this evidence is enough to accept the effect; its physical size is checked elsewhere.
bool convincing(const Comparison& comparison, const SelectionOptions& options);

}  // namespace m100::lab::identify
