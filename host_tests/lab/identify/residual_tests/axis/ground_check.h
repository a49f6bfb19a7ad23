// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "host_tests/lab/identify/axis_problem.h"

namespace m100::lab::identify {

/// Why a change is no change of a parameter: on one side of the date the vehicle does not answer the stick, or the
/// response is too still for flight. Empty: the vehicle flies on both sides. Preconditions: the change was found in the
/// problem's free run; the fit is of its family.
std::string ground_reason(const AxisProblem& problem, const Request& request, const Fit& fit, const Change& change);

}  // namespace m100::lab::identify
