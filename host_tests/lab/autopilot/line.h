// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "host_tests/lab/autopilot/run.h"

namespace m100::lab::autopilot {

/// Runs in real time, or on simulated ports in their host's time, until --duration is over or a signal arrives.
void run_on_line(const Options& options, const sim::Plant& plant, const sim::N1Config& config);

}  // namespace m100::lab::autopilot
