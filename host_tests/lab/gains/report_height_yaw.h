// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/companion/files/text/json.h"
#include "firmware/model/vehicle.h"

namespace m100::lab::gains {

/// Prints the margins of the height loop (climb command) and the yaw loop (rate command) on both channels: those of the
/// vehicle file and the worst over gain, frequency or time constant +-20 %, damping +-0.1 and delay +-10 ms.
/// Wanted: 6 dB and 45 degrees.
/// - Height, as flown: the response of the flight code's height filter and law, in its ticks, to a small climb.
/// - Yaw: a continuous model about rest, L = K hold(s) axis(s) / s, without the observer. Its delay is the axis' own
///   plus 30 ms, the age of the pose and of the tick.
/// @returns {"height": {"virtual_rc": {..., "corners": {...}}, "movement": {...}}, "yaw": {...}}
Json report_height_yaw(const model::Vehicle& vehicle);

}  // namespace m100::lab::gains
