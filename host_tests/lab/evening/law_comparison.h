// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

#include "host_tests/lab/evening/folder.h"
#include "host_tests/lab/loop/paired_flights.h"

namespace m100::lab::evening {

/// Compares the laws of vehicle.toml and corrected.toml on the corrected model. A copy of vehicle.toml is slowed down
/// until it keeps the margins of corrected.toml there, if it can (loop::at_ordered_margin). Copy and corrected.toml fly
/// course.txt in simulation, in pairs. If corrected.toml is worse horizontally (loop::PairedErrors), it becomes that
/// copy but for the climb axis; if it is worse in height, its climb axis becomes that of vehicle.toml. Records the
/// margins and the pairs. Errors: InputError.
void compare_laws(Folder& folder);

/// The errors of the flights of the course, before and after, by the names of record_errors() ("pose_m", ...), with
/// their verdict: from the pairs of flights; of one flight each, from the spread inside them. Errors: InputError.
using FlownErrors = std::map<std::string, loop::PairedErrors>;
FlownErrors compare_flights(const Folder& folder);

/// The verdict on the flights of the course, then the result of compare_laws; one sentence each.
std::vector<std::string> law_verdicts(const Folder& folder, const FlownErrors& flown);

}  // namespace m100::lab::evening
