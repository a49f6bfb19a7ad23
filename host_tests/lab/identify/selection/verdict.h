// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "host_tests/lab/identify/output/result.h"

namespace m100::lab::identify {

// The verdict "nothing missing", "explained" or "unexplained": one rule for the stick axes and for translation.

struct ValidationComparison {
  double ratio = 1.0;         ///< mean square of validation over mean square of training
  double beyond_start = 1.0;  ///< the same ratio without the starts of the blocks; the F test uses it
  double probability = 1.0;   ///< of so large a ratio by chance (F test); 1 where the ratio is below one
  double training_degrees = 0.0;
  double validation_degrees = 0.0;
  bool are_starts_measured = true;  ///< the rows of the log determine the initial states of the blocks
  bool across_a_change = false;     ///< a change lies between or within the parts, so they need not agree
};

/// F test of two coloured residuals, given block by block. Degrees of freedom: samples over the sum of squared
/// autocorrelations (summed over both signs of the lag, up to the first value below 0.05). With eight training blocks
/// or more they are limited by the spread of the blocks' mean squares, because gusts make the power vary.
///
/// The F test leaves out the starts of the blocks. A block that begins where the stick has just jumped starts from a
/// wrong state, and its large error there is no evidence about the model.
/// @param parameters  number fitted to the training part; each takes one degree of freedom
/// @param start  samples at the start of each block that depend on its initial state. A block that is not longer is
///   left out; a part of which nothing would remain keeps all its samples.
ValidationComparison compare_validation(const std::vector<std::vector<double>>& training,
                                        const std::vector<std::vector<double>>& validation, std::size_t parameters,
                                        std::size_t start = 0);

/// Upper tail of the F distribution, P(F > ratio), for degrees of freedom above zero.
double f_tail(double ratio, double numerator_degrees, double denominator_degrees);

/// Limits of check_completeness().
struct CompletenessLimits {
  double min_probability = 0.003;  ///< of the F test, nominal; used only where nothing was named
  double min_ratio = 1.1;  ///< of root mean squares without the starts of the blocks; a smaller one passes the F test
  /// A larger ratio of root mean squares is refused. If the result has no change, it leaves out the starts of the
  /// blocks where slow rows hide them or the result has an effect.
  double max_ratio = 1.5;
  double min_evidence = 0.05;     ///< a ratio without the starts is refused only with a smaller probability
  double min_fit_percent = 50.0;  ///< a model with a smaller fit of the validation part is incomplete
  double floor_factor = 2.0;      ///< below this times the noise floor, a validation error is accepted with any fit
};

/// Adds to `unexplained` the reasons against a complete model: the comparison of the two parts, and the fit. With
/// `parts.across_a_change`, the change is the result and the parts need not agree. Preconditions: final_model,
/// effects, changes and noise_floor of the result are set.
void check_completeness(const ValidationComparison& parts, const CompletenessLimits& limits, IdentifyResult& result);

/// Whether a finding rules out the verdict "nothing missing": all do except notes, gaps and time on the ground.
bool forbids_nothing_missing(const Finding& finding);

/// "nothing_missing", "explained" or "unexplained", from the rest of the result.
std::string verdict_of(const IdentifyResult& result);

}  // namespace m100::lab::identify
