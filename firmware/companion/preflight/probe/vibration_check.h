// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "firmware/companion/preflight/check_result.h"

namespace m100::companion::preflight {

/// Listens to the autopilot for four seconds and measures the vibration (est::Vibration) as a flight does, with the
/// rotors as they turn meanwhile. kDoubtful: it would be reported in flight, or it could not be measured.
CheckResult check_vibration(const std::string& port, std::uint32_t baud);

}  // namespace m100::companion::preflight
