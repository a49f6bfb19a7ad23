// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>

#include "firmware/companion/fly/fly.h"
#include "firmware/companion/fly/pilotage.h"
#include "firmware/companion/fly/preparation.h"
#include "firmware/companion/room/overheard_line.h"

namespace m100::companion {

/// The result of a flight for `fly --json`, in SI units.
/// @param stalls ticks that came more than two periods late
nlohmann::json flight_result(const FlyOptions& options, const Orders& orders, const Pilotage& pilotage,
                             const app::FlightController<double>& controller, std::uint32_t stalls,
                             const safety::Limits& limits);
/// The counts of messages from the room.
nlohmann::json room_result(const HeardStats& heard, std::uint32_t parameters_not_set);

}  // namespace m100::companion
