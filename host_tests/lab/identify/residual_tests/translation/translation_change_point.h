// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "host_tests/lab/identify/model/model_family.h"
#include "host_tests/lab/identify/model/translation/translation_data_set.h"
#include "host_tests/lab/identify/output/result.h"

namespace m100::lab::identify::translation {

/// What became another in mid-flight: steady_wind, body_bias, tilt_gain, linear_drag or mass (change_scan.h), at most
/// one. It must be likelier than none by 30 and large enough to mean something (0.15 m/s^2 of wind).
/// Preconditions: the fit is of the training part; both parts are of one log, or `validation` is null.
std::vector<Change> change_points(const TranslationDataSet& training, const TranslationDataSet* validation,
                                  const Fit& fit);

/// A force that grows with the distance from a place: a tether, a wall, a ground. Asked of what the fit leaves of the
/// training part: a pull likelier than none by 60 (tethers give thousands, free flights at most 20) and of more than
/// 0.1 m/s^2. @returns at most one finding; nothing where the position was not logged.
std::vector<Finding> position_force(const TranslationDataSet& training, const Fit& fit);

}  // namespace m100::lab::identify::translation
