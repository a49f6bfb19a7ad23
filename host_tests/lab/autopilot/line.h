// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "host_tests/lab/autopilot/run.h"

namespace m100::lab::autopilot {

/// Runs on pseudo-terminals in real time, or on simulated ports in their host's time, until the end or a signal.
void run_on_line(const Options& options, const sim::Plant& plant, const sim::N1Config& config);

}  // namespace m100::lab::autopilot
