// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "host_tests/lab/autopilot/run.h"

namespace m100::lab::autopilot {

/// Runs in real time on pseudo-terminals, or in the host's time on simulated ports, until the duration is over.
void run_on_line(const Options& options, const sim::Plant& plant, const sim::N1Config& config);

}  // namespace m100::lab::autopilot
