// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace m100::tools::identify {

// What is left when the selection has ended: is it still predictable? Shared by the stick axes and by translation.

/// A regressor, sample by sample on the same clock as the residual. Several may belong to one source, e.g. lags.
struct Regressor {
  std::string source;  ///< what a reader is told: "stick_roll", "stick_roll * stick_pitch", "battery"
  std::vector<double> values;
};

struct ResidualInput {
  double sample_period_s = 0.01;
  std::vector<double> residual;          ///< blocks one after the other
  std::vector<std::size_t> block_begin;  ///< first sample of each block, ascending; the first is 0
  std::vector<Regressor> regressors;
  double noise_floor = 0.0;  ///< declared root mean square; 0: not declared
};

struct ResidualOptions {
  std::size_t shifts = 19;       ///< circular shifts of the residual; the best of them must be beaten
  double minimum_share = 0.08;   ///< least cross-validated share of the variance that counts
  double periodic_share = 0.25;  ///< one spectral line with more than this share of the power is periodic
  double floor_factor = 2.0;     ///< residual above this times the declared floor is a disturbance
};

struct ResidualFinding {
  std::vector<std::string> unexplained;  ///< sentences; empty: at the floor
  double predictable_share = 0.0;        ///< cross-validated share of the residual's variance
  double shifted_share = 0.0;            ///< the best of the shifted residuals
};

ResidualFinding test_residual(const ResidualInput& input, const ResidualOptions& options);

}  // namespace m100::tools::identify
