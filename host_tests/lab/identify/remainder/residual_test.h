// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace m100::lab::identify {

// What is left when the selection has ended: is it still predictable? Shared by the stick axes and by translation.

/// Regressors of one source, e.g. the lags of a stick. Each column has one value per sample of the residual, or one per
/// row of its thinning (residual_share.h).
struct RegressorGroup {
  std::string source;  ///< what a reader is told: "stick_roll", "stick_roll * stick_pitch", "battery"
  std::vector<std::vector<double>> columns;
};

struct ResidualInput {
  double sample_period_s = 0.01;
  double row_s = 0.0;                          ///< between the rows in which the log was written, where that is more
  std::vector<std::vector<double>> residuals;  ///< one per direction of motion; the stick axes have one
  std::vector<std::size_t> block_begin;        ///< first sample of each block, ascending, the first is 0; blocks are
                                               ///< what cross validation leaves out
  std::vector<double> time_s;                  ///< of each sample on the clock of its flight; empty: all in one row
  std::vector<std::size_t> flight;             ///< in which each sample lies: one clock each; empty: all in one
  std::vector<RegressorGroup> groups;          ///< may explain the residual
  std::vector<RegressorGroup> activity;        ///< may explain its size
  /// Of each sample, by how much the residual may be off because the input is not known between two rows; at least 0.
  /// It is taken from the residual's size before that is asked about. Empty: the input is known.
  std::vector<double> unknown;
  double noise_floor = 0.0;  ///< declared root mean square; 0: not declared
};

struct ResidualOptions {
  std::size_t shifts = 99;       ///< circular shifts of the residual, the best of which must be beaten
  double shift_factor = 1.5;     ///< by this factor
  double shift_margin = 0.03;    ///< and this share of the variance
  double minimum_share = 0.12;   ///< least cross-validated share of the variance that counts
  double periodic_share = 0.25;  ///< one spectral line with more than this share of the power is periodic
  double periodic_peak = 20.0;   ///< and this many times its neighbourhood
  double drift_share = 0.2;      ///< a straight line over time with more than this share of the power
  double drift_t = 6.0;          ///< and this t, over means of blocks, is a drift
  double burst_sigma = 6.0;      ///< an excursion beyond this many robust sigmas is a burst
  double burst_share = 0.25;     ///< bursts that hold more than this share of the power are reported
  double floor_factor = 2.0;     ///< residual above this times the declared floor is a disturbance
};

struct ResidualFinding {
  std::vector<std::string> unexplained;  ///< sentences; empty: nothing left that could be predicted
  struct Share {
    std::string source;
    double predicted = 0.0;  ///< cross-validated share of the variance
    double shifted = 0.0;    ///< the best that any group reached on any shifted residual
  };
  std::vector<Share> shares;  ///< all groups, largest first
  double line_hz = 0.0;       ///< strongest spectral line
  double line_share = 0.0;
  double rms = 0.0;
};

/// Ridge regression of the residual on each group, cross-validated over blocks and held against circular shifts of the
/// residual; the same for its size; the strongest spectral line; the declared floor. Fewer than five blocks cannot be
/// tested, and the finding says so.
/// Preconditions: at least one residual, all of one length; time_s and flight (unless empty) have that length, and
/// every column that or the number of thinned rows; block_begin is not empty. Cost: linear in samples, quadratic in the
/// columns of a group.
ResidualFinding test_residual(const ResidualInput& input, const ResidualOptions& options);

/// Appends the samples of another stretch to the groups of the same source and number of columns; into nothing: takes
/// them. A group that one of both lacks is dropped: its columns would be too short. Precondition: at least one group is
/// common to all that is merged.
void merge(std::vector<RegressorGroup>& into, std::vector<RegressorGroup> more);

/// Correlation of a series with itself `lag` samples earlier, about its mean or about zero. 0 where it has no power.
double autocorrelation(const std::vector<double>& values, std::size_t lag, bool about_mean);

/// Lags of a channel as columns: the value `lag` samples ago, for each lag.
std::vector<std::vector<double>> lagged(const std::vector<double>& channel, const std::vector<std::size_t>& lags);

}  // namespace m100::lab::identify
