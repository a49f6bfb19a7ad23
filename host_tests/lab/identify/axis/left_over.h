// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "host_tests/lab/identify/axis/free_run.h"

namespace m100::lab::identify {

/// What a whitened fit leaves, and what its own numbers could still explain of it: for asking of many models whether
/// a fit of theirs would be worth its time.
class LeftOver {
 public:
  /// @param fit, knobs  a fit of the run and what was free in it. The run must outlive this.
  LeftOver(const FreeRun& run, const WhitenedFit& fit, std::span<const Knob> knobs);

  /// Likelihood ratio of a step of free size toward another model, beside steps of all own numbers: what a fit that
  /// starts there will gain, to first order.
  /// @param error  of the other model, row by row of the run
  double promise(const Rows& error) const;

 private:
  Rows toward(const Rows& error) const;

  const FreeRun& run_;
  double offset_;
  Rows error_;
  Ar filter_;
  Rows white_;   ///< innovations, without what the own numbers explain
  Columns own_;  ///< orthonormal: steps of the own numbers and of the offset
};

}  // namespace m100::lab::identify
