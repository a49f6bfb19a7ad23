// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "host_tests/lab/flight/flight_series.h"
#include "host_tests/lab/paired_errors.h"

namespace m100::lab::flight {

/// The error of one pose: pose minus course, at the pose's time of capture, along x, y and z.
struct TrackingError {
  double course_s = 0.0;  ///< since the law first flew
  std::array<double, 3> error_m{};
  double distance_m() const;
};

/// The errors of the poses while the law flew, from one second after it began: before that, the aircraft flies
/// to the course. The reference is interpolated linearly between ticks.
std::vector<TrackingError> tracking_errors(const FlightSeries& flight);

/// Root mean square and maximum of a flight's errors.
struct Tracking {
  std::size_t poses = 0;
  Interval rms_m;
  double max_m = 0.0;
  double max_at_s = 0.0;  ///< since the law first flew
  double horizontal_rms_m = 0.0;
  double vertical_rms_m = 0.0;
};
/// The interval is a jackknife over blocks of 2.5 s (at least 4), because errors of neighbouring poses are alike. It is
/// the spread inside this flight: another flight in another air may differ by more.
Tracking tracking_of(const std::vector<TrackingError>& errors);

/// One pair of flights: their root mean squares, and the difference over the blocks of 2.5 s in which both have errors.
/// The blocks are paired by the time on the course.
PairedErrors compare_pair(const std::vector<TrackingError>& before, const std::vector<TrackingError>& after);

/// The errors along some axes: x, y, z, each 1 or 0.
std::vector<TrackingError> along(std::vector<TrackingError> errors, const std::array<double, 3>& axes);

}  // namespace m100::lab::flight
