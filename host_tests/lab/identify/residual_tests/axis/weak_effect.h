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

/// Finds the likeliest effect that a model lacks, each fitted to whitened free runs together with all parameters of the
/// model. The selection requires a better prediction of blocks, in which strong slow air hides effects that a
/// likelihood ratio shows; such an effect rules out the verdict "nothing missing". Each effect starts at several sizes,
/// and is fitted where a step toward it promises a better score; where the model jumps at its dead zone's edge, also
/// together with a dead zone without the jump. An effect is certain only if all IntersampleHypotheses confirm it; rows
/// after a step of the stick count less. Cost: a simulation for each starting point, a few fits.
/// @returns nothing where no effect of significant size exceeds the ratio that chance exceeds in one log of a thousand.
std::optional<WeakEffect> weak_effect(const AxisData& data, const std::vector<Range>& ranges, const AxisFamily& family,
                                      const Fit& fit);

}  // namespace m100::lab::identify
