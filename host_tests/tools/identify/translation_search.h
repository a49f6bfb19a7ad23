// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <span>
#include <vector>

#include "host_tests/tools/identify/periodic.h"
#include "host_tests/tools/identify/translation_regression.h"

namespace m100::tools::identify::translation {

inline constexpr double kLongestLag_s = 0.5;
inline constexpr double kLongestOffset_s = 0.3;
inline constexpr double kStrongestWind_m_s = 40.0;
inline constexpr double kLargestAngle_rad = 1.0;

/// Measured acceleration in the rows of `part`.
Vector measured_rows(const TranslationBlocks& part);

struct Solution {
  Vector linear;
  double sum_of_squares = 0.0;
};

/// Weighted least squares for given searched parameters.
Solution solve(const TranslationBlocks& part, const Vector& measured, const Structure& structure,
               const Searched& searched, std::span<const int> weights);

/// Coordinate search with shrinking steps: the few searched parameters are nearly independent of each other.
class Search {
 public:
  Search(const TranslationBlocks& part, const Vector& measured, const Structure& structure,
         std::span<const int> weights)
      : part_(part), measured_(measured), structure_(structure), weights_(weights), used_(searched_in(structure)) {}

  double cost(const std::array<double, kSearched>& at) const {
    const Searched searched = as_searched(at);
    return solve(part_, measured_, structure_, searched, weights_).sum_of_squares;
  }

  void refine(std::array<double, kSearched>& at, std::array<double, kSearched> steps, int rounds) const {
    const std::array<double, kSearched> low{
        0.0, -kLongestOffset_s, 0.02, -kStrongestWind_m_s, -kStrongestWind_m_s, -kLargestAngle_rad};
    const std::array<double, kSearched> high{kLongestLag_s,      kLongestOffset_s,   10.0,
                                             kStrongestWind_m_s, kStrongestWind_m_s, kLargestAngle_rad};
    double best = cost(at);
    for (int round = 0; round < rounds; ++round) {
      bool moved = false;
      for (std::size_t k = 0; k < kSearched; ++k) {
        if (!used_[k]) {
          continue;
        }
        for (const double sign : {1.0, -1.0}) {
          std::array<double, kSearched> trial = at;
          trial[k] = std::clamp(at[k] + sign * steps[k], low[k], high[k]);
          const double value = cost(trial);
          if (value < best) {
            best = value;
            at = trial;
            moved = true;
            break;
          }
        }
      }
      if (!moved) {
        for (double& step : steps) {
          step *= 0.4;
        }
      }
    }
  }

  bool anything() const { return std::find(used_.begin(), used_.end(), true) != used_.end(); }

 private:
  const TranslationBlocks& part_;
  const Vector& measured_;
  const Structure& structure_;
  std::span<const int> weights_;
  std::array<bool, kSearched> used_;
};

/// Measured less predicted.
Vector residual_of(const TranslationBlocks& part, const Vector& measured, const Fit& fit);

/// Residual of one axis with its times, for the line search.
LineSeries axis_series(const TranslationBlocks& part, const Vector& residual, std::size_t axis,
                       std::span<const int> weights);

}  // namespace m100::tools::identify::translation
