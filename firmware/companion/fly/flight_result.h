// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "firmware/companion/files/text/json.h"
#include "firmware/companion/fly/flight_files.h"
#include "firmware/companion/fly/flight_sequencer.h"
#include "firmware/companion/fly/fly.h"
#include "firmware/companion/ground_station/ground_station_tap.h"

namespace m100::companion {

/// The result of a flight for `fly --json`, in SI units.
/// @param stalls ticks that came more than two periods after the one before
Json flight_result(const FlyOptions& options, const FlightFiles& files, const FlightSequencer& sequencer,
                   const app::FlightController<double>& controller, std::uint32_t stalls, const safety::Limits& limits);
/// What came over the pose port: the poses, when the clock of their source was set, and the counts of messages from the
/// ground station. @param signatures may be null.
Json pose_result(const app::FlightController<double>& controller, const link::SignedLineStats* signatures,
                 std::span<const ClockStep> steps, const GroundStationStats& heard);

}  // namespace m100::companion
