// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "host_tests/lab/logs/flight_log.h"

namespace m100::oracle {

// Flights with hidden effects: roll and pitch by axis_vehicle.h, with its own rotation, forces and effects of
// translation, in steps of 2 ms.

/// Hidden effects by name, with their sizes in their own units. Names are those of the contract's effect table, and
/// "sine", "slung_load", "dropout", "product" for effects that the library does not have.
using HiddenEffects = std::map<std::string, double>;

struct FlightPlan {
  std::string axis;  ///< "roll" or "translation": which motion carries the effects
  HiddenEffects hidden;
  std::uint64_t seed = 1;
  double length_s = 45.0;
  bool logs_thrust = false;  ///< a wind-tunnel log: thrust_ratio and thrust_dir, no accelerometer, no sticks
  bool constant_heading = false;
};

/// Flies and logs at 100 Hz with noise: position 1 mm, attitude 2 mrad, velocity 12 mm/s, force 0.08 m/s^2; the air
/// moves attitude by 4 mrad and acceleration by 0.05 m/s^2, coloured. Parameters of the vehicle vary with the seed.
lab::logs::FlightLog fly(const FlightPlan& plan);

}  // namespace m100::oracle
