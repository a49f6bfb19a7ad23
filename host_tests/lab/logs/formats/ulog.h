// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "host_tests/lab/logs/raw_log.h"

namespace m100::lab::logs {

/// ULog of any version. Columns are `topic.field`, `topic.field[0]`, `topic.nested.field`, and `topic:1.field` for the
/// second instance; each topic has its own clock (`topic.timestamp`, in seconds).
std::unique_ptr<RawLog> open_ulog(const std::string& file);

}  // namespace m100::lab::logs
