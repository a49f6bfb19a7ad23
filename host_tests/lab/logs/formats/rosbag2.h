// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "host_tests/lab/logs/raw_log.h"

namespace m100::lab::logs {

/// ROS 2 bag with sqlite3 storage and CDR encoding; columns as in a ROS 1 bag. Types: those of ros_types.h, and all
/// that the bag itself defines.
std::unique_ptr<RawLog> open_rosbag2(const std::string& file);

}  // namespace m100::lab::logs
