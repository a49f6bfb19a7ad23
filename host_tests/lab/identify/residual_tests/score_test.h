// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "host_tests/lab/identify/model/axis/free_run.h"

namespace m100::lab::identify {

/// Estimates cheaply how much better other models would fit than a whitened fit, without fitting them (Rao's score
/// test).
class ScoreTest {
 public:
  /// @param fit, free_parameters  a fit of the run and its free parameters. The run must outlive this object.
  ScoreTest(const FreeRun& run, const WhitenedFit& fit, std::span<const FreeParameter> free_parameters);

  /// Likelihood ratio, to first order, of a step toward another model. The size of the step and all parameters of the
  /// whitened fit are free.
  /// @param error  of the other model, row by row of the run
  double statistic(const Rows& error) const;

 private:
  Rows difference_to(const Rows& error) const;

  const FreeRun& run_;
  double offset_;
  Rows error_;
  Ar filter_;
  Rows white_;   ///< innovations, without the part that the own parameters explain
  Columns own_;  ///< orthonormal: steps of the own parameters and of the offset
};

}  // namespace m100::lab::identify
