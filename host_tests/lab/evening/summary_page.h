// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "host_tests/lab/evening/folder.h"

namespace m100::lab::evening {

/// Writes summary.html: the question, the findings, the errors before and after, and which file was made from which.
void write_summary(const Folder& folder);

/// One line for each error before and after the correction, each flight that oscillated, and each of law_verdicts().
std::string before_and_after(const Folder& folder);

}  // namespace m100::lab::evening
