// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "host_tests/lab/identify/answer/result.h"

namespace m100::lab::identify {

// Whether a clean bill ("nothing_missing") may be given: one rule for the stick axes and for translation.

/// How much worse unseen data are predicted than those that were fitted.
struct PartsCompared {
  double ratio = 1.0;         ///< mean square of validation over mean square of training
  double beyond_start = 1.0;  ///< the same of what comes after the start of each block: what the F test is asked of
  double probability = 1.0;   ///< of so large a ratio by chance (F test); 1 where the ratio is below one
  double training_degrees = 0.0;
  double validation_degrees = 0.0;
  bool across_a_change = false;  ///< the parts do not lie on one side of what changed: they need not agree
};

/// F test of two coloured residuals. Degrees of freedom: samples over the sum of squared autocorrelations (summed over
/// both signs of the lag to the first value below 0.05), the number of independent squares that a coloured Gaussian
/// series is worth; and no more than the training part's blocks show by how far their mean squares differ, where there
/// are eight or more: air in gusts is worth less. Errors stand block by block; blocks are correlated within, not
/// across.
///
/// A block that begins where the stick has just jumped begins in a wrong state, because no smoothing of a measurement
/// follows a kink: its first half second can hold a third of the power of thirty blocks. That is one accident and not
/// as many squares as it has samples, and says nothing of the model: the F test leaves the starts out.
/// @param parameters  that were fitted to the training part; they take their number of degrees of freedom.
/// @param start  samples of each block in which its start shows; a block that is not longer than that is left out, and
///   where that would be all of a part, nothing is.
PartsCompared compare_parts(const std::vector<std::vector<double>>& training,
                            const std::vector<std::vector<double>>& validation, std::size_t parameters,
                            std::size_t start = 0);

/// Upper tail of the F distribution, P(F > ratio), for degrees of freedom above zero.
double f_tail(double ratio, double numerator_degrees, double denominator_degrees);

/// What the guard asks beside the result itself.
struct GuardLimits {
  double least_probability = 0.003;  ///< nominal, and asked only where nothing was named,
  double least_ratio = 1.1;          ///< of root mean squares: less is no other vehicle, however certain it is;
  double most_ratio = 1.5;  ///< of root mean squares: more forbids a clean bill whatever the F test says; a name
                            ///< only beyond the starts of the blocks
  double least_fit_percent = 50.0;  ///< a model that explains half of what is seen is not the whole truth,
  double floor_factor = 2.0;        ///< unless what is left is at the declared or measured floor
};

/// Adds to `unexplained` what the comparison of the two parts, of fit and of floor forbids to call complete. What
/// changed stands in result.changes: then it is the answer and the parts need not agree.
/// Preconditions: final_model, noise_floor and changes of the result are there.
void guard(const PartsCompared& parts, const GuardLimits& limits, IdentifyResult& result);

/// Whether a finding forbids a clean bill: all but notes, gaps and time on the ground.
bool forbids_clean_bill(const Finding& finding);

/// "nothing_missing", "explained" or "unexplained", from all else of the result.
std::string verdict_of(const IdentifyResult& result);

}  // namespace m100::lab::identify
