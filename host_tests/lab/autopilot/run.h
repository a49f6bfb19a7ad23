// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "host_tests/lab/autopilot/options.h"
#include "host_tests/sim/autopilot/n1_autopilot.h"
#include "host_tests/sim/world/plant.h"

namespace m100::lab::autopilot {

/// Whether SIGINT or SIGTERM has arrived, so that the program must write its summary and end.
bool stop_requested();

/// Runs in real time on pseudo-terminals, or in the host's time on simulated ports, until the duration is over.
void run_on_line(const Options& options, const sim::Plant& plant, const sim::N1Config& config);

/// Runs the flight image in the emulator instead of a pseudo-terminal: UART1 is the autopilot's line, UART2 the pose,
/// and the simulation drives its time. The operator asks for control after 6 s and gives it back 3 s before the end.
void run_with_board(const Options& options, const sim::Plant& plant, const sim::N1Config& config);

}  // namespace m100::lab::autopilot
