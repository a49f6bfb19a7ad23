// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "host_tests/lab/identify/request.h"
#include "host_tests/lab/logs/flight_log.h"
#include "host_tests/sim/world/plant.h"

namespace m100::host_tests {

/// The log of an excited flight of a simulated evening.
struct ExcitedFlight {
  sim::Plant plant;          ///< drawn from the seed, about the measured aircraft
  lab::logs::FlightLog log;  ///< as the flight's own log is read, with the shipped map
  /// Of the first and of the second stick, from its first movement to a second after its last.
  std::array<lab::identify::Range, 2> moved_s;
  bool is_over = false;  ///< false: it was aborted
};

/// Flies what an evening flies: the law holds the place, and the movements of `m100-lab excite` follow each other,
/// first of one stick and then of the other, with returns between them. The vehicle file of the flight is the aircraft
/// as a hand's log may show it, each number some per cent wrong.
/// @param rates  throttle and yaw; otherwise roll and pitch
ExcitedFlight fly_excited(std::uint64_t seed, bool rates);

/// An axis of such a flight.
struct ExcitedAxis {
  std::string name;
  lab::identify::Range within_s;        ///< as an evening gives it
  std::vector<std::string> declared;    ///< as an evening declares it
  std::map<std::string, double> truth;  ///< by the names of the final model's parameters
};
std::vector<ExcitedAxis> axes_of(const ExcitedFlight& flight, bool rates);

}  // namespace m100::host_tests
