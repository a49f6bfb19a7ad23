// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "host_tests/lab/evening/folder.h"

namespace m100::lab::evening {

/// Writes summary.html: what was asked, what was found, before and after, which file was made from which.
void write_summary(const Folder& folder);

/// Every error before and after the correction, one a line: the flights' by channel, and the predictions'.
std::string before_and_after(const Folder& folder);

}  // namespace m100::lab::evening
