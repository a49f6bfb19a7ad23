// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/companion/fly/fly.h"

namespace m100::companion {

/// Sends requests to release control, and nothing else, for a program whose two processes are dead or stopped: as many
/// rounds as the second process, at its spacing. Waits first until the port is free, for as long as a second process
/// that lives may still send. A stopped one keeps the port; then the requests are sent all the same, which needs root.
/// @returns false: the port cannot be opened, or did not take a whole round.
bool release_only(const FlyOptions& options, const link::LinkConfig& config);

}  // namespace m100::companion
