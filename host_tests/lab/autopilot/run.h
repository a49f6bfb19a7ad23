// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "host_tests/lab/autopilot/options.h"
#include "host_tests/sim/autopilot/n1_autopilot.h"
#include "host_tests/sim/world/plant.h"

namespace m100::lab::autopilot {

/// Whether SIGINT or SIGTERM has arrived, so that the program must write its summary and end.
bool stop_requested();

}  // namespace m100::lab::autopilot
