// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "host_tests/lab/identify/axis/axis_study.h"

namespace m100::lab::identify {

/// Why what changes at a date is no number of the vehicle: on one side of it the stick is not answered, or the response
/// rests as no air lets it. Empty: it flies on both sides. Preconditions: the change was found in the study's free run;
/// the fit is of its family.
std::string no_flight_beside(const AxisStudy& study, const Request& request, const Fit& fit, const Change& change);

}  // namespace m100::lab::identify
