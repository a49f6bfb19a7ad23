// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "host_tests/lab/logs/flight_log.h"
#include "host_tests/property/identify/stranger_bound.h"
#include "host_tests/property/identify/stranger_vehicle.h"

namespace m100::host_tests {

/// Everything that is drawn before a stranger's flight.
struct StrangerFlight {
  std::string axis = "roll";
  StrangerTraits before, after;
  double change_s = 1e9;
  StrangerHand hand = StrangerHand::kPilot;
  double reach = 120.0;   ///< counts
  double feedback = 0.0;  ///< counts per unit of the response, of a closed loop
  double duration_s = 60.0;
  double stick_s = 0.02;          ///< between two values of the sticks, held in between
  double response_early_s = 0.0;  ///< by which the logged response runs before the logged sticks
  StrangerNoise noise;
  double air_later = 1.0;                     ///< factor of the air from change_s on
  double quantum = 0.0;                       ///< of the logged response
  double jitter = 0.0;                        ///< of the rows' stamps, share of a row
  double rest_from_s = 1e9, rest_to_s = 1e9;  ///< the vehicle stands on the ground, whatever the stick does
  double own_from_s = 1e9, own_to_s = 1e9;    ///< another mode flies: the response has nothing to do with the sticks
};

/// What was written.
struct StrangerRows {
  std::string axis;
  std::vector<double> time_s, own, other, response;
  /// Through the reader of logs, on its own clock.
  lab::logs::FlightLog log() const;
};

struct StrangerRecord {
  StrangerRows rows;
  StrangerSticks sticks;           ///< as they arrived
  std::vector<double> clean;       ///< response without noise, one value for each row
  std::vector<std::size_t> steps;  ///< of the simulation at which the rows stand
};

/// A vehicle with random numbers, a random hand, air, clock and logger.
StrangerFlight random_flight(StrangerChance& chance);
StrangerRecord fly(const StrangerFlight& flight, StrangerChance& chance);

}  // namespace m100::host_tests
