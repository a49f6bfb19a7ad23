// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "firmware/model/vehicle.h"
#include "host_tests/lab/identify/output/result.h"

namespace m100::lab::identify {

/// Writes an identified stick axis, or translation, into a vehicle. Roll and pitch also clear `design` and `robust`.
/// @returns sentences about numbers that the vehicle file cannot hold; empty when it holds all of them.
std::vector<std::string> put_axis(const IdentifyResult& result, model::Vehicle& vehicle);

/// Compares the believed with the found parameters of the final model, in the model's order. A parameter that the
/// vehicle file cannot hold is left out. `matters`: the believed value lies outside of the interval, and differs from
/// the found value by more than the smallest physically significant difference.
std::vector<Refitted> refitted(const model::Vehicle& believed, const IdentifyResult& result);

/// Updates the axis' section of a vehicle file, or creates the file; `source` names the log that gave the numbers. The
/// axis' former intervals and rivals are removed. @returns what put_axis returns. @throws FileError.
std::vector<std::string> update_vehicle_file(const std::string& path, const IdentifyResult& result,
                                             const std::string& source);

}  // namespace m100::lab::identify
