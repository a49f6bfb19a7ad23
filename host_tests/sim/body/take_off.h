// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "host_tests/sim/world/vehicle_port.h"

namespace m100::sim {

/// Brings a body from the ground to a place where a flight may begin: the pilot starts the motors, climbs, flies to the
/// place and holds it. It ends when the body has rested within 0.1 m for 2 s, or after 20 s at the place in gusty air.
/// @throws PhysicsError the body does not leave the ground, or does not come to the place.
void take_off(VehiclePort& body, const core::Vector<double, 3>& place_w_m);

}  // namespace m100::sim
