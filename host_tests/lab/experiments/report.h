// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "host_tests/lab/experiments/results.h"

namespace m100::lab::experiments {

/// The file name of the page of one flight of a task (flight::flight_page()).
std::string page_name(const Task& task);
/// Writes a self-contained page with the table and figures. Errors: InputError.
void write_report(const std::string& folder, const std::vector<TaskResult>& results, const std::string& about);

}  // namespace m100::lab::experiments
