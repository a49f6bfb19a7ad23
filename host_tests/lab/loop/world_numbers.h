// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/companion/files/text/json.h"
#include "firmware/model/vehicle.h"
#include "host_tests/sim/world/plant.h"

namespace m100::lab::loop {

/// Every number of an axis that the simulated world or the vehicle file has: {"roll": {"dead_zone_counts": {"world":
/// 26, "vehicle": 16.1, "without": 0}}}; "without" is the value of an axis that lacks the effect. For reports only,
/// after the loop is closed: neither controller nor identification see it.
Json world_numbers(const sim::Plant& world, const model::Vehicle& vehicle);

}  // namespace m100::lab::loop
