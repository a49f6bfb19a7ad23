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
/// [{"at_s", "by_s"}]: when the clock of the source of pose was set, and by how much.
Json clock_steps_json(std::span<const ClockStep> steps);
/// The counts of messages from the ground station.
Json ground_station_result(const GroundStationStats& heard);

}  // namespace m100::companion
