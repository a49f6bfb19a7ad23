// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "host_tests/lab/identify/model/axis/axis_blocks.h"
#include "host_tests/lab/identify/model/axis/axis_family.h"
#include "host_tests/lab/identify/model/axis/free_run.h"
#include "host_tests/lab/identify/request.h"
#include "host_tests/lab/identify/residual_tests/axis/axis_residual.h"

namespace m100::lab::identify {

/// Hypotheses about the stick between its rows: interpolated, as logged; held at its last row; already at its next row.
/// Only what all confirm is certain: if the stick has two positions, a dead zone or a limit acts on interpolated values
/// alone. All runs have the weights of weight_by_input_uncertainty().
class IntersampleHypotheses {
 public:
  /// The data must outlive this object. @param model  that the weights are estimated with
  IntersampleHypotheses(const AxisData& data, const std::vector<Range>& ranges, const model::StickAxis& model);

  const FreeRun& as_logged() const { return as_logged_; }
  /// Smallest value of `ratio`, a function of a FreeRun, under the two hypotheses that hold the stick. Each run exists
  /// only while its ratio is computed, because that of an hour takes 15 MB.
  template <typename Ratio>
  double min_over_held(const Ratio& ratio) const {
    return std::min(ratio_of_held(false, ratio), ratio_of_held(true, ratio));
  }
  /// The smallest under all three.
  template <typename Ratio>
  double min_over_all(const Ratio& ratio) const {
    return std::min(ratio(as_logged_), min_over_held(ratio));
  }

 private:
  template <typename Ratio>
  double ratio_of_held(bool next, const Ratio& ratio) const {
    const AxisData held = hold_between_rows(as_logged_.data(), next);
    FreeRun run(held, ranges_);
    run.set_weights(as_logged_.weights());
    return ratio(run);
  }

  std::vector<Range> ranges_;
  FreeRun as_logged_;
};

/// Whether a lead zero t may only restore what an undersampled stick loses at a frequency w: a line between rows T
/// apart loses (w T)^2 / 12, a held stick half of that; the zero restores (w t)^2 / 2, at T / 2 as much as both.
bool sharpens_rows(const AxisData& data, const model::StickAxis& model);

/// Standard error of a mean delay between two times, for an undersampled stick whose every movement between two rows
/// was a step at a uniformly distributed moment: a row over the root of twelve, divided by the root of the effective
/// number of movements. So a few steps leave a larger error than a stick that moves all the time. 0 for other sticks.
double step_time_error_s(const AxisData& data, double from_s, double to_s);

/// Weighs the innovations by the uncertainty that the unknown stick between its rows causes. Each step between two rows
/// (also of one sample) may have happened at any moment of the row, which adds a variance to the rows after it; the
/// share of this variance relative to that of the air is estimated by maximum likelihood.
void weight_by_input_uncertainty(FreeRun& run, const model::StickAxis& model);

/// All parameters of a structure as free_parameters_of(), with the delay free down to one row below zero: a row shows
/// the stick since the row before, so a response without delay may begin up to a row early. time_offset() finds earlier
/// ones.
std::vector<FreeParameter> free_parameters_within_row(const AxisFamily& family, const Fit& fit);

/// Smallest likelihood ratio of an effect of the fit over all hypotheses about the stick between its rows, with weighed
/// innovations; infinity for trim_offset and where the effect cannot be removed. A straight line between two rows makes
/// a stick that jumped begin early and end late. A dead zone in the model compensates this; under the other two
/// hypotheses it is not needed.
double min_ratio_over_hypotheses(const AxisData& data, const std::vector<Range>& ranges, const AxisFamily& family,
                                 const Fit& fit, const std::string& effect);

}  // namespace m100::lab::identify
