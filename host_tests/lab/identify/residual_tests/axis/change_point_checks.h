// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "host_tests/lab/identify/request.h"
#include "host_tests/lab/identify/residual_tests/axis/axis_change_point.h"

namespace m100::lab::identify {

/// Smallest likelihood ratio of a change over all hypotheses about an undersampled stick (intersample_hypotheses.h),
/// with weighted innovations; infinity if the stick is not undersampled. Below kCertainChange the unknown moment of a
/// step of the stick may have caused the change.
double min_ratio_over_hypotheses(const AxisData& data, const std::vector<Range>& ranges, const AxisFamily& family,
                                 const Fit& fit, const ChangePoint& change);

/// Searches both sides of a change for a second change. A temporary change, such as another mode of the autopilot for a
/// while, is two changes.
/// @returns a second change whose likelihood ratio is more than half of the first one's, if there is one.
std::optional<Change> second_change_point(const AxisData& data, const std::vector<Range>& ranges,
                                          const AxisFamily& family, const Fit& fit, const ChangePoint& change);

/// Whether a model with the change leaves bursts in the innovations of the log, which then has an event of another
/// kind: a stick that was not logged for a while, or a jump of the response itself.
/// @returns the time of the largest innovation, if innovations beyond six robust standard deviations hold more than a
/// tenth of the power. Of Student's t with five degrees of freedom, and so of gusty air, they hold a twentieth.
std::optional<double> burst_beside(const FreeRun& run, const ChangePoint& change);

/// Schwarz's penalty of the parameters that a model has more than another one.
double price_of(std::size_t parameters, std::size_t fewer, const FreeRun& run);

/// Adds `first` as a rival of `change`, which was found with the structure of one side of it. It does so if the names
/// differ and `change` is not clearly better after the penalty of its additional parameters.
void add_rival_change(const ChangePoint& first, const FreeRun& run, ChangePoint& change);

}  // namespace m100::lab::identify
