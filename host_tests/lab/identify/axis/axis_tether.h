// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host_tests/lab/identify/answer/result.h"
#include "host_tests/lab/identify/axis/axis_blocks.h"
#include "host_tests/lab/identify/axis/axis_family.h"
#include "host_tests/lab/identify/axis/free_run.h"

namespace m100::lab::identify {

/// A pull back by the way flown: a tether, a wall, a floor of air.
struct AxisTether {
  double rate_per_s = 0.0;        ///< of the response that each metre beyond the edge takes away
  double edge_m = 0.0;            ///< counted from where the log begins, along the response
  bool above = false;             ///< it pulls back from beyond the edge upward; else downward
  double largest = 0.0;           ///< of the response, in its unit: what it takes away at its farthest
  double likelihood_ratio = 0.0;  ///< over the model without it
  double score = 0.0;             ///< of the model with it, as WhitenedFit::score
};

/// For responses that are a speed: whether what a fit leaves is a pull toward where the vehicle came from, in
/// proportion to the way beyond an edge (either sense, four edges each and none). The way is the integral of the
/// measured response, which needs no other channel. A speed's error and its own integral hang together a little by
/// themselves (a random walk seems to return to its mean), as in the tests for a unit root; those ratios stay below 16.
/// @returns nothing where the likelihood ratio is below 30, where it pulls away or where even its largest is below what
///   the model leaves. Precondition: the data have no other stick, and the fit is of `family`.
std::optional<AxisTether> tether_of(const AxisData& data, const std::vector<Range>& ranges, const AxisFamily& family,
                                    const Fit& fit);

/// In words. @param response  name of the signal that is pulled back
Finding tether_finding(const AxisTether& tether, const std::string& response);

}  // namespace m100::lab::identify
