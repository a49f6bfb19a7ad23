// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "host_tests/lab/logs/flight_log.h"
#include "host_tests/property/identify/unseen_log_bound.h"
#include "host_tests/property/identify/unseen_log_vehicle.h"

namespace m100::host_tests {

/// All random numbers of an unseen log's flight.
struct UnseenLogFlight {
  std::string axis = "roll";
  UnseenLogParameters before, after;
  double change_s = 1e9;
  UnseenLogInput hand = UnseenLogInput::kPilot;
  double reach = 120.0;   ///< counts
  double feedback = 0.0;  ///< gain of a closed loop, counts per unit of the response
  double duration_s = 60.0;
  double stick_s = 0.02;          ///< sample period of the sticks, held in between
  double response_early_s = 0.0;  ///< by which the logged response precedes the logged sticks
  UnseenLogNoise noise;
  double air_later = 1.0;                     ///< factor of the air after change_s
  double quantum = 0.0;                       ///< rounding of the logged response
  double jitter = 0.0;                        ///< of the rows' time stamps, share of the sample period
  double rest_from_s = 1e9, rest_to_s = 1e9;  ///< the vehicle is on the ground, independent of the stick
  double own_from_s = 1e9, own_to_s = 1e9;    ///< another mode flies: the response does not depend on the sticks
};

/// The rows of the log.
struct UnseenLogRows {
  std::string axis;
  std::vector<double> time_s, own, other, response;
  /// The flight log as the log reader makes it, on its own clock.
  lab::logs::FlightLog log() const;
};

struct UnseenLogRecord {
  UnseenLogRows rows;
  UnseenLogSticks sticks;          ///< as received
  std::vector<double> clean;       ///< response without noise, one value for each row
  std::vector<std::size_t> steps;  ///< simulation step of each row

  /// The sticks as they were if each row up to a date had been read just before the stick's next sample: earlier by a
  /// sample of the stick. A log of these sticks has the same rows.
  UnseenLogSticks sticks_read_late(double late_s, double date_s) const;
  /// Response and steps of the rows inside of the requested ranges.
  UnseenLogRecord inside(std::vector<std::pair<double, double>> train,
                         const std::vector<std::pair<double, double>>& validate) const;
};

/// Draws vehicle, pilot, air, clock and logger.
UnseenLogFlight random_flight(UnseenLogRandom& rng);
UnseenLogRecord fly(const UnseenLogFlight& flight, UnseenLogRandom& rng);

}  // namespace m100::host_tests
