// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "host_tests/lab/logs/raw_log.h"

namespace m100::lab::logs {

/// ROS 1 bag 2.0 with uncompressed or (if built with libbz2) bz2 chunks. Columns are `/topic.field.path`,
/// `/topic.axes[0]`, and `/topic.time`: the header's time stamp, or without one the time of reception, in seconds from
/// the bag's first message.
std::unique_ptr<RawLog> open_rosbag(const std::string& file);

}  // namespace m100::lab::logs
