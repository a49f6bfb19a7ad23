// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host_tests/lab/identify/model/axis/axis_family.h"
#include "host_tests/lab/identify/request.h"

namespace m100::lab::identify {

/// An effect that is certain but explains too little to be named.
struct WeakEffect {
  std::string name;
  double likelihood_ratio = 0.0;  ///< twice the logarithm
};

/// Finds the likeliest effect that a model lacks. Each effect is fitted to whitened free runs together with all
/// parameters of the model, and must be confirmed by all IntersampleHypotheses. Strong slow air hides such an effect
/// from the selection, which requires a better prediction of blocks. Cost: a simulation for each starting point, a few
/// fits.
/// @returns nothing if no effect of significant size exceeds the ratio that chance exceeds in one log of a thousand.
std::optional<WeakEffect> weak_effect(const AxisData& data, const std::vector<Range>& ranges, const AxisFamily& family,
                                      const Fit& fit);

}  // namespace m100::lab::identify
