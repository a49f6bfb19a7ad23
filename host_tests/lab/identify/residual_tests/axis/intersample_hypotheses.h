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

/// Three hypotheses about the stick between its rows: interpolated, held at its last row, or already at its next row.
/// An effect is certain only if it is found under all of them. All runs have the weights of
/// weight_by_input_uncertainty().
class IntersampleHypotheses {
 public:
  /// The data must outlive this object. @param model  that the weights are estimated with
  IntersampleHypotheses(const AxisData& data, const std::vector<Range>& ranges, const model::StickAxis& model);

  const FreeRun& as_logged() const { return as_logged_; }
  /// Smallest value of `ratio`, a function of a FreeRun, with the stick held at its last row and with it already at its
  /// next row.
  template <typename Ratio>
  double min_over_held(const Ratio& ratio) const {
    return std::min(ratio_of_held(false, ratio), ratio_of_held(true, ratio));
  }
  /// Smallest value of `ratio` under all three hypotheses.
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

/// Whether a lead zero of the model may only restore the fast motion that an undersampled stick loses between its rows:
/// it is shorter than half a row.
bool sharpens_rows(const AxisData& data, const model::StickAxis& model);

/// Standard error [s] of the mean time of the stick's movements between `from_s` and `to_s`, if each movement was a
/// step at an unknown moment between two rows. It decreases with the number of movements. 0 for a stick that is not
/// undersampled.
double step_time_error_s(const AxisData& data, double from_s, double to_s);

/// Sets the weights of a run's innovations: smaller after steps of the stick. A step may have happened at any moment
/// between two rows, which adds a variance to the innovations after it. The size of this variance relative to that of
/// the air is estimated by maximum likelihood.
void weight_by_input_uncertainty(FreeRun& run, const model::StickAxis& model);

/// The parameters of free_parameters_of(), with a delay that may be as small as minus one row: a row may show a step of
/// the stick up to a row late, so that the response seems early.
std::vector<FreeParameter> free_parameters_within_row(const AxisFamily& family, const Fit& fit);

/// Compares the models with and without an effect of the fit under each of the IntersampleHypotheses. @returns the
/// smallest likelihood ratio; infinity for trim_offset and if the effect cannot be removed.
double min_ratio_over_hypotheses(const AxisData& data, const std::vector<Range>& ranges, const AxisFamily& family,
                                 const Fit& fit, const std::string& effect);

}  // namespace m100::lab::identify
