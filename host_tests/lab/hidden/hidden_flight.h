// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "host_tests/lab/logs/flight_log.h"

namespace m100::lab::hidden {

// Flights with hidden effects. The vehicle here shares no code with the identification: it has its own integration
// (Euler steps of 2 ms), rotation and effects.

/// Hidden effects by name, with their sizes in their own units. Names are those of model::kAxisEffects and
/// kTranslationEffects, and "sine", "slung_load", "dropout", "product" for effects that the library does not have.
using HiddenEffects = std::map<std::string, double>;

/// The size of an effect; 0: it is not there.
inline double value_of(const HiddenEffects& hidden, const char* name) {
  const auto found = hidden.find(name);
  return found == hidden.end() ? 0.0 : found->second;
}

struct FlightPlan {
  std::string axis;  ///< "roll" or "translation": which motion carries the effects
  HiddenEffects hidden;
  std::uint64_t seed = 1;
  double length_s = 45.0;
  bool logs_thrust = false;  ///< a wind-tunnel log: thrust_ratio and thrust_dir, no accelerometer, rates or sticks
  bool constant_heading = false;
};

/// Flies and logs at 100 Hz. Standard deviations of the noise: position 1 mm, attitude and thrust direction 2 mrad,
/// rates 10 mrad/s, velocity 12 mm/s, force 0.08 m/s^2 (z: 0.1); of the coloured motion by air: attitude 4 mrad,
/// acceleration 0.05 m/s^2. The seed varies the vehicle, its noise and the pilot.
logs::FlightLog fly(const FlightPlan& plan);

}  // namespace m100::lab::hidden
