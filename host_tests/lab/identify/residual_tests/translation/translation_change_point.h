// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "host_tests/lab/identify/model/model_family.h"
#include "host_tests/lab/identify/model/translation/translation_data_set.h"
#include "host_tests/lab/identify/output/result.h"

namespace m100::lab::identify::translation {

/// The parameter that changed in flight, at most one: steady_wind, body_bias, tilt_gain, linear_drag or mass
/// (change_scan.h). The likelihood ratio against no change must be at least 30, and the change large enough to matter
/// (0.15 m/s^2 of wind). Preconditions: the fit is of the training part; `validation` is null or of the same log.
std::vector<Change> change_points(const TranslationDataSet& training, const TranslationDataSet* validation,
                                  const Fit& fit);

/// A force that grows with the distance from a place (tether, wall, ground), in the residual of the training part. Its
/// likelihood ratio must be at least 60 (tethers give thousands, free flights at most 20), and its pull at one standard
/// deviation of the position at least 0.1 m/s^2 on x or y. @returns at most one finding; nothing without a position.
std::vector<Finding> position_force(const TranslationDataSet& training, const Fit& fit);

}  // namespace m100::lab::identify::translation
