// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "firmware/model/vehicle.h"
#include "host_tests/lab/identify/answer/result.h"

namespace m100::lab::identify {

/// Writes an identified stick axis, or translation, into a vehicle.
/// @returns sentences about what the vehicle file has no place for; empty when everything fitted.
std::vector<std::string> put_axis(const IdentifyResult& result, model::Vehicle& vehicle);

/// What was believed of the parameters of the final model, set against what was found, in the model's order. A number
/// that the vehicle file has no place for is left out. `matters`: the believed value lies outside the interval, and by
/// more than the least difference that means something physically.
std::vector<Refitted> refitted(const model::Vehicle& believed, const IdentifyResult& result);
/// The same from a vehicle file. @throws VehicleFileError.
std::vector<Refitted> refitted(const std::string& path, const IdentifyResult& result);

/// Updates the section of the axis in a vehicle file, or makes the file; `source` says which log the numbers came from.
/// @returns what put_axis returns. @throws VehicleFileError.
std::vector<std::string> update_vehicle_file(const std::string& path, const IdentifyResult& result,
                                             const std::string& source);

}  // namespace m100::lab::identify
