// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host_tests/lab/identify/model/axis/axis_blocks.h"
#include "host_tests/lab/identify/model/axis/axis_family.h"
#include "host_tests/lab/identify/model/axis/free_run.h"
#include "host_tests/lab/identify/output/result.h"

namespace m100::lab::identify {

/// A force that pulls back in proportion to the distance flown: a tether, a wall, the ground.
struct AxisTether {
  double rate_per_s = 0.0;        ///< reduction of the response [m/s] per metre beyond the edge
  double edge_m = 0.0;            ///< position of the edge from the start of each flight, along the response
  bool above = false;             ///< it acts above the edge; otherwise below it
  double largest = 0.0;           ///< reduction at the farthest point, in the unit of the response
  double likelihood_ratio = 0.0;  ///< over the model without it
  double score = 0.0;             ///< of the model with it, as WhitenedFit::score
};

/// Tests whether a response that is a speed is reduced in proportion to the distance flown beyond an edge. The distance
/// is the integral of the measured response. Several edges are tried in both directions.
/// @returns nothing if the likelihood ratio is at most 16, if the force pushes away, or if its largest value is at most
///   the residual's root mean square. Precondition: the data have no other stick, and the fit is of `family`.
std::optional<AxisTether> detect_tether_force(const AxisData& data, const std::vector<Range>& ranges,
                                              const AxisFamily& family, const Fit& fit);

/// The finding of a tether. @param response  name of the signal that it reduces
Finding tether_finding(const AxisTether& tether, const std::string& response);

}  // namespace m100::lab::identify
