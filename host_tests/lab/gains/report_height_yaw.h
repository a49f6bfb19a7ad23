// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "firmware/model/vehicle.h"

namespace m100::lab::gains {

/// Prints the margins of the height loop (climb command) and the yaw loop (rate command) on both channels, of the
/// vehicle file and over gain, frequency or time constant +-20 %, damping +-0.1 and delay +-10 ms. Continuous about
/// rest: L = C(s) hold(s) axis(s) / s exp(-s delay), the hold of the channel's command period, and a delay of the axis'
/// own plus 30 ms, the age of the pose and of the tick. The observers, which predict through that age, are left out, so
/// the real margins are a little larger. Wanted: 6 dB and 45 degrees.
/// @returns {"height": {"virtual_rc": {..., "corners": {...}}, "movement": {...}}, "yaw": {...}}
nlohmann::json report_height_yaw(const model::Vehicle& vehicle);

}  // namespace m100::lab::gains
