// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "firmware/model/axis_effect.h"
#include "host_tests/lab/hidden/hidden_flight.h"
#include "host_tests/lab/identify/output/result.h"
#include "host_tests/lab/logs/flight_log.h"

namespace m100::lab::hidden {

/// The values with which inject() can add this effect to this axis: the range of the vehicle file; for "translation"
/// that of the effect's first parameter which is not a frequency. Nothing: it cannot be added.
std::optional<model::Bounds> addable(const std::string& effect, const std::string& axis);

/// Adds named effects to a measured flight and keeps everything else unchanged.
///
/// Stick axes: the response y becomes y + M(u, effects) - M(u), with the stick u and the fitted model M, simulated by
/// the code of the hidden flights. If M has the same effect, the sizes add; ratios multiply, and a limit replaces
/// that of M. The measured residual (air, autopilot, all else) stays.
/// Translation: the vehicle is assumed to have flown the same path with the tilt that the added horizontal force f
/// (over mass) would have required: thrust over mass times the body's z axis, T b3, becomes T b3 - f. A logged
/// accelerometer gets the values that it would then measure.
///
/// @param fitted the declared model's parameters as identify reports them; unused for translation.
/// @throws InputError: an unknown axis, a missing signal, or an effect that cannot be added.
logs::FlightLog inject(const logs::FlightLog& log, const std::string& axis, const identify::ModelResult& fitted,
                       const HiddenEffects& effects);

}  // namespace m100::lab::hidden
