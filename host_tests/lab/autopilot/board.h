// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "host_tests/lab/autopilot/run.h"

namespace m100::lab::autopilot {

/// Runs the flight image in QEMU, for 30 s without --duration: its UART1 is the autopilot's line, its UART2 the pose,
/// and the simulation drives its clock. The operator requests control after 6 s and releases it 3 s before the end.
void run_with_board(const Options& options, const sim::Plant& plant, const sim::N1Config& config);

}  // namespace m100::lab::autopilot
