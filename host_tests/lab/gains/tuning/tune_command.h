// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "firmware/companion/files/vehicle_file.h"
#include "host_tests/lab/gains/margin_box.h"

namespace m100::lab::gains {

/// `gains --tune`: makes [design] and [design.robust] of the file, prints the Pareto curve of worst peak sensitivity
/// and flown error, and what each limit costs. If an axis is of first order, only the input weight is chosen.
/// @param present vehicle file of the law that flies now: where it keeps the limits, the new design flies no worse
/// @param path of the vehicle file, which also describes the simulated aircraft
void tune_vehicle(companion::VehicleFile& file, const model::Vehicle& present,
                  const std::vector<OpenStructure>& structures, const std::string& path);

/// Prints which of gain, frequency and delay limits the aircraft, by the peak sensitivity with `believed`, and what
/// mode robust costs in a simulated hover.
void print_what_limits(const model::Vehicle& believed, const OpenStructure& own, const companion::VehicleFile& file,
                       const std::string& path);

}  // namespace m100::lab::gains
