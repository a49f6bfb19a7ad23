// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/companion/fly/fly.h"

namespace m100::companion {

/// Flies a course by the pose from the second port. @returns true: control was taken and given back on order, the
/// excitation, if any, was flown to its end, and no limit cycle was detected.
bool fly_course(const FlyOptions& options, const link::LinkConfig& config, hal::SerialPort& port);

}  // namespace m100::companion
