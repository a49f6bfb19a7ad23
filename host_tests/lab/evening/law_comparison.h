// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

#include "host_tests/lab/evening/folder.h"
#include "host_tests/lab/paired_errors.h"

namespace m100::lab::evening {

/// Compares the laws of vehicle.toml and corrected.toml on the corrected model, by simulated pairs of flights of
/// course.txt: as flown, and with the law of vehicle.toml slowed down to the margins of corrected.toml, if it can be
/// (loop::at_ordered_margin). Where corrected.toml is worse as flown, horizontally or in the climb, the law of
/// vehicle.toml replaces it there, unless Settings::keep_worse. Records the margins and the pairs. Errors: InputError.
void compare_laws(Folder& folder);

/// The errors of the flights of the course before and after the correction, by the names of record_errors() ("pose_m",
/// ...), each with a verdict on their difference. Errors: InputError.
using FlownErrors = std::map<std::string, PairedErrors>;
FlownErrors compare_flights(const Folder& folder);

/// The verdict on the flights of the course, then the result of compare_laws; one sentence each.
std::vector<std::string> law_verdicts(const Folder& folder, const FlownErrors& flown);

}  // namespace m100::lab::evening
