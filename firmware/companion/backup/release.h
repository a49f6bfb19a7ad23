// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/companion/fly/fly.h"

namespace m100::companion {

/// Sends requests to release control, and nothing else, for a program whose two processes are dead or stopped. It sends
/// as many rounds as the second process, at its spacing. It first waits until the port is free, for as long as a living
/// second process may send. If the port is still held then, it sends all the same, which needs root.
/// @returns false: the port cannot be opened, or did not take a whole round.
bool release_only(const FlyOptions& options, const link::LinkConfig& config);

}  // namespace m100::companion
