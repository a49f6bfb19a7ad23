// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "firmware/model/vehicle.h"
#include "host_tests/tools/identify/result.h"

namespace m100::tools::identify {

/// Writes an identified stick axis, or translation, into a vehicle.
/// @returns sentences about what the vehicle file has no place for; empty when everything fitted.
std::vector<std::string> put_axis(const IdentifyResult& result, model::Vehicle& vehicle);

/// Updates the section of the axis in a vehicle file, or makes the file; `source` says which log the numbers came from.
/// @returns what put_axis returns. @throws VehicleFileError.
std::vector<std::string> update_vehicle_file(const std::string& path, const IdentifyResult& result,
                                             const std::string& source);

}  // namespace m100::tools::identify
