// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "firmware/companion/files/text/json.h"
#include "firmware/ctl/excitation.h"
#include "host_tests/lab/evening/folder.h"
#include "host_tests/lab/logs/flight_log.h"

// The results of a flight of the evening: the program's JSON answer and the log.
namespace m100::lab::evening {

inline constexpr double kSettled_s = 1.0;  ///< from the start of control; errors before are ignored

/// The JSON object that the board's command wrote; empty if the file holds no JSON object.
Json result_of(const Folder& folder, const std::string& result);

/// From the first entry of the failsafe's state nominal to the last exit from it, in seconds on the log's clock.
std::pair<double, double> nominal(const Json& result);

/// From the excitation's first movement of this stick in the flight NAME to a second after its last, in seconds on the
/// log's clock; (0, 0): the flight is not in the folder, or did not move it.
std::pair<double, double> moved(const Folder& folder, const std::string& name, ctl::ExcitedStick stick);

/// Roll and pitch of a flight and their sticks; as extra columns heading, the reference's heading and the pose's age.
logs::FlightLog tracked(const Folder& folder, const std::string& log);

/// Records the root mean square errors of NAME.ulg from its course: "pose_m.NAME", "horizontal_m.NAME", and by channel
/// "x_m.NAME", "y_m.NAME", "height_m.NAME", "heading_deg.NAME". Each pose is compared with the course at the pose's
/// time of capture (flight::tracking_errors).
/// @returns false: no pose was captured under control from a second after the start on; nothing is recorded
bool record_errors(Folder& folder, const std::string& name);

/// Compares the files that a flight's log holds with those of the folder. @returns in one sentence which one differs,
/// or why the log cannot be read; empty: neither, or the step is not a flight.
/// @param reads the files that the step NAME reads; the step made NAME.ulg.
std::string differing_input(const Folder& folder, const std::string& name, const std::vector<std::string>& reads);

}  // namespace m100::lab::evening
