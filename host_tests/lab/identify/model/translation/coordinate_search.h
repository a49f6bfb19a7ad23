// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <span>
#include <vector>

#include "host_tests/lab/identify/model/translation/normal_equations.h"
#include "host_tests/lab/identify/model/translation/translation_regression.h"
#include "host_tests/lab/identify/residual_tests/periodic_force.h"

namespace m100::lab::identify::translation {

/// Measured acceleration in the rows of `part`.
Vector measured_rows(const TranslationBlocks& part);

struct Solution {
  Vector linear;
  double sum_of_squares = 0.0;  ///< weighted; with a penalty if the drag by which a wind acts is not positive
  std::vector<double> winds;    ///< x and y of each flight's wind (flight_winds.h); empty: none was fitted
};

/// Weighted least squares within the bounds of the effects, for given searched parameters. `measured` has part.rows
/// values; `weights` one for each block.
/// @param normals  cache, used only for this part and these measured values
Solution solve(const TranslationBlocks& part, const Vector& measured, const Structure& structure,
               const SearchPoint& searched, std::span<const int> weights, NormalEquations& normals);

/// Minimises the error of the linear solution over the searched parameters. One parameter is changed at a time, with
/// shrinking steps, because the parameters are few and nearly independent of each other.
class CoordinateSearch {
 public:
  /// All arguments must outlive the search; their shapes are those of solve().
  CoordinateSearch(const TranslationBlocks& part, const Vector& measured, const Structure& structure,
                   std::span<const int> weights, NormalEquations& normals)
      : part_(part),
        measured_(measured),
        structure_(structure),
        weights_(weights),
        normals_(normals),
        used_(searched_in(structure)) {}

  double cost(const SearchPoint& at) const {
    return solve(part_, measured_, structure_, at, weights_, normals_).sum_of_squares;
  }
  /// Improves `at`, starting with the given step size of every parameter; unused slots are not changed.
  void refine(SearchPoint& at, double model::SearchedParameter::*step, int rounds) const;
  bool has_parameters() const;

 private:
  /// Steps up, or else down, if that costs less than the best so far. @returns whether it stepped.
  bool step_along(std::size_t slot, double step, SearchPoint& at, double& best) const;

  const TranslationBlocks& part_;
  const Vector& measured_;
  const Structure& structure_;
  std::span<const int> weights_;
  NormalEquations& normals_;
  std::array<bool, kSearched> used_;
};

/// Measured minus predicted, in the rows of `part`, which may be of another log than the fit.
Vector residual_of(const TranslationBlocks& part, const Vector& measured, const Fit& fit);

/// Residual of one axis with its times, without the blocks of weight 0; no weights: of all blocks.
TimeSeries axis_series(const TranslationBlocks& part, const Vector& residual, std::size_t axis,
                       std::span<const int> weights);

/// Frequency of the strongest spectral peak in the horizontal axes of a residual.
double strongest_peak_hz(const TranslationBlocks& part, const Vector& residual, std::span<const int> weights);

}  // namespace m100::lab::identify::translation
