// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "firmware/model/axis_effect.h"
#include "host_tests/lab/hidden/hidden_flight.h"
#include "host_tests/lab/identify/answer/result.h"
#include "host_tests/lab/logs/flight_log.h"

namespace m100::lab::hidden {

/// The values with which inject() can make this effect on this axis ("translation" is one): the range of the vehicle
/// file, or of the effect's first number that is not searched. Nothing: it cannot.
std::optional<model::Interval> addable(const std::string& effect, const std::string& axis);

/// Adds named effects to a measured flight, everything else of it staying as it was.
///
/// Stick axes: y + M(u, effects) - M(u), where M is the fitted model simulated by this folder's own code. The measured
/// residual, that is the air, the autopilot and whatever else is in the flight, remains in it.
/// Translation: the vehicle is believed to have flown the same path with the tilt that the added force would have asked
/// for, T b3 becoming T b3 - f; the accelerometer, where logged, feels what it then would.
///
/// @param fitted the declared model's parameters as identify reports them; unused for translation.
/// @throws InputError: an effect that cannot be added to this axis, or a signal that is missing.
logs::FlightLog inject(const logs::FlightLog& log, const std::string& axis, const identify::ModelResult& fitted,
                       const Hidden& effects);

}  // namespace m100::lab::hidden
