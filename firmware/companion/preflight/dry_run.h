// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/companion/fly/fly.h"

namespace m100::companion {

/// Does everything of a flight that needs no sending. @returns true: at the end telemetry is fresh, and, if a pose port
/// and a vehicle are named, the pose is fresh and the estimate healthy.
bool dry_run(const FlyOptions& options, const link::LinkConfig& link, hal::Uart& autopilot);

}  // namespace m100::companion
