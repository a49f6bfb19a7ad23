// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "firmware/core/eigen.h"

namespace m100::lab::identify {

// Tests whether the residual after the selection is still predictable. Shared by the stick axes and by translation.

/// Regressors of one source, e.g. the lags of a stick. Each column has one value per sample of the residual, or one per
/// row of its thinning (predictable_share.h).
struct RegressorGroup {
  std::string source;  ///< its name in reports: "stick_roll", "stick_roll * stick_pitch", "battery"
  std::vector<std::vector<double>> columns;
  double ridge = 0.02;  ///< penalty, in shares of a column's own power: assumed share of noise in it
};

struct ResidualInput {
  double sample_period_s = 0.01;
  double row_s = 0.0;                          ///< between the rows of the log file, if that is longer
  std::vector<std::vector<double>> residuals;  ///< one per direction of motion; the stick axes have one
  std::vector<std::size_t> block_begin;        ///< first samples of the blocks that cross-validation leaves out, from 0
  std::vector<double> time_s;                  ///< of each sample on the clock of its flight; empty: without a gap
  std::vector<std::size_t> flight;             ///< number of each sample's flight (own clock each); empty: one flight
  std::vector<RegressorGroup> groups;          ///< may explain the residual
  std::vector<RegressorGroup> activity;        ///< may explain its size
  /// For each sample or thinned row: error that the unknown input between two rows may cause, at least 0. It is
  /// subtracted from the residual's size in the tests by regressors, by activity and for bursts. Empty: no such error.
  std::vector<double> input_uncertainty;
  double noise_floor = 0.0;  ///< declared root mean square; 0: not declared
};

struct ResidualOptions {
  std::size_t shifts = 99;       ///< circular shifts of the residual; a share must exceed the best of them
  double shift_factor = 1.5;     ///< times this factor
  double shift_margin = 0.03;    ///< plus this share of the variance
  double minimum_share = 0.12;   ///< least cross-validated share of the variance that counts
  double periodic_share = 0.25;  ///< one spectral peak with more than this share of the power is periodic
  double periodic_peak = 20.0;   ///< and this many times its neighbourhood
  double drift_share = 0.2;      ///< a straight line over time is a drift with more than this share of the power
  double drift_t = 6.0;          ///< and more than this t, over means of blocks
  double burst_sigma = 6.0;      ///< an excursion beyond this many robust sigmas is a burst
  double burst_share = 0.25;     ///< bursts that hold more than this share of the power are reported
  double floor_factor = 2.0;     ///< residual above this times the declared floor is a disturbance
};

struct ResidualFinding {
  std::vector<std::string> unexplained;  ///< sentences; empty: the residual is not predictable
  struct Share {
    std::string source;
    double predicted = 0.0;  ///< cross-validated share of the variance
    double shifted = 0.0;    ///< the best that any group reached on any shifted residual
  };
  std::vector<Share> shares;  ///< all groups, largest first
  double rms = 0.0;
};

/// Tests whether the residual is predictable from a group, by cross-validated ridge regression compared with circular
/// shifts of the residual, and its size from `activity`. Also tests for spectral peaks, drift and bursts, and against
/// the noise floor. Fewer than five blocks cannot be tested, and the finding says so. Preconditions: at least one
/// residual, all of one length; time_s and flight (unless empty) have that length; a column has that length or the
/// number of thinned rows. Cost: linear in samples, quadratic in the columns of a group.
ResidualFinding test_residual(const ResidualInput& input, const ResidualOptions& options);

/// Appends the samples of another stretch to the groups of the same source and number of columns. A group that only one
/// of the two has is dropped, because its columns would be too short; an empty `into` takes all of `more`.
/// Precondition: at least one group is common to all stretches.
void merge(std::vector<RegressorGroup>& into, std::vector<RegressorGroup> more);

/// Excursions of a series far beyond its robust standard deviation (1.4826 times the median size).
struct Bursts {
  double share = 0.0;       ///< of the series' power that they hold; 0 where the median size is 0
  std::size_t largest = 0;  ///< index of the largest value
};
/// @param beyond  sizes of the values without the error that the unknown input may cause; same length, at least one
/// value
Bursts bursts_of(const Eigen::VectorXd& values, const Eigen::VectorXd& beyond, double sigmas);

/// Correlation of a series with itself `lag` samples earlier, about its mean or about zero. 0 without power.
double autocorrelation(const std::vector<double>& values, std::size_t lag, bool about_mean);

}  // namespace m100::lab::identify
