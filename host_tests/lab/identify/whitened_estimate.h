// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "host_tests/lab/identify/model/axis/axis_family.h"
#include "host_tests/lab/identify/output/result.h"
#include "host_tests/lab/identify/request.h"

namespace m100::lab::identify {

/// A fit with the intervals of its coordinates.
struct WhitenedEstimate {
  Fit fit;
  std::vector<Interval> coordinates;  ///< one for each parameter of the fit, in fitted units; NaN: it was not free
};

/// The fit's numbers by maximum likelihood over whitened free runs (fit_whitened()), with 95 % intervals by the
/// jackknife over stretches. Unlike the least squares of a simulation it is consistent where the stick answers the air,
/// because the innovations of the air do not depend on the stick before them (Ljung, System Identification,
/// 1999, 13.4).
/// @param ranges  of the training part. @returns nothing where they are shorter than ten seconds together
std::optional<WhitenedEstimate> whitened_estimate(const AxisFamily& family, const AxisData& data,
                                                  const std::vector<Range>& ranges, const Fit& fit);

}  // namespace m100::lab::identify
