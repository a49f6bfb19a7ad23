// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "host_tests/lab/logs/raw_log.h"

namespace m100::lab::logs {

/// Text separated by commas, semicolons or tabs; its first line with text has the names. Reads quotes, CRLF and BOMs.
std::unique_ptr<RawLog> open_csv(const std::string& file);

}  // namespace m100::lab::logs
