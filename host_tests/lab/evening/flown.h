// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "host_tests/lab/evening/folder.h"
#include "host_tests/lab/logs/flight_log.h"

// What a flight of the evening left: the program's answer, and the log.
namespace m100::lab::evening {

inline constexpr double kSettled_s = 1.0;  ///< after control begins, before errors count

/// The JSON that the board's command wrote; an empty object where it is none.
nlohmann::json result_of(const Folder& folder, const std::string& result);

/// Seconds on the log's clock during which the law commanded.
std::pair<double, double> nominal(const nlohmann::json& result);

/// Sticks, tilts and pose of a flight, with x, y, z and heading of the reference and the pose's age beside them.
logs::FlightLog tracked(const Folder& folder, const std::string& log);

/// Notes how far NAME.ulg was from its course, as root mean squares: "pose_m.NAME", "horizontal_m.NAME", and by channel
/// "x_m.NAME", "y_m.NAME", "height_m.NAME", "heading_deg.NAME". The pose is compared with where the course was when the
/// pose was captured.
/// @param vehicle file that flew.
/// @returns false: the log holds no second of a flight under control
bool note_errors(Folder& folder, const std::string& name, const std::string& vehicle);

/// A flight's log holds the files that it was flown with. @returns what differs from the folder's of now, in one
/// sentence; empty: nothing, or the step is no flight.
/// @param reads files of the step NAME, which made NAME.ulg.
std::string flown_with_others(const Folder& folder, const std::string& name, const std::vector<std::string>& reads);

}  // namespace m100::lab::evening
