// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "host_tests/lab/logs/raw_log.h"

namespace m100::lab::logs {

/// MATLAB 5 or 7.3 MAT-file. Columns are paths: `Experiment1.RCData.channel[1]` is row 1 (as MATLAB counts) of a matrix
/// whose longer side is time; `states.mat:x[1]` lies in another MAT-file of the same folder. Struct arrays and cells
/// are not followed.
std::unique_ptr<RawLog> open_mat(const std::string& file);

}  // namespace m100::lab::logs
