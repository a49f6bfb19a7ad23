// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "host_tests/lab/evening/steps.h"

namespace m100::lab::evening {

/// Writes the folder's numbers into a vehicle file: the larger input weight (kWeightIncreases), the trims (kTrimmed).
void adjust(const Folder& folder, const std::string& vehicle);
/// Writes the files that a person may change before they are used: flight file, course, column maps, first vehicle
/// file. Files that already exist are kept.
void write_initial_files(const Folder& folder);

}  // namespace m100::lab::evening
