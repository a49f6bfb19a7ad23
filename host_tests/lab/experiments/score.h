// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "host_tests/lab/experiments/trace.h"

namespace m100::lab::experiments {

/// Root mean squares over a window, as the paper's results table has them (IV-C: pose by Euclidean distance), and
/// beside them what position hides: tilt, how much the command moves, and the largest error.
struct Cell {
  double pose_m = 0.0;
  double x_m = 0.0;
  double y_m = 0.0;
  double z_m = 0.0;
  double roll_deg = 0.0;
  double pitch_deg = 0.0;
  double yaw_deg = 0.0;
  double tilt_deg = 0.0;               ///< of the tilt of the thrust axis
  double input_variation_deg_s = 0.0;  ///< summed change of both tilt commands per second
  double worst_m = 0.0;                ///< largest distance from the reference
  double off_nominal_share = 0.0;      ///< of the ticks not in the ladder's top state
};

/// Root mean squares over [from, to) seconds. An empty window gives zeros.
Cell score(const Trace& trace, double from_s, double to_s);

/// Whether the flight was flown and never left the top of the ladder, nominal and coast. No flight did not stay.
bool stayed(const Trace& trace);

/// Mean over flights, and the sample standard deviation; entry by entry.
Cell mean_of(const std::vector<Cell>& cells);
Cell spread_of(const std::vector<Cell>& cells);

/// One number of a Cell with the name that JSON and tables use.
struct CellField {
  const char* name;
  double Cell::*member;
};
const std::vector<CellField>& cell_fields();

/// Root mean square over a window of `window_s` of the distance left, if a vehicle that can tilt at once, and by no
/// more than `tilt_rad`, covers steps of these sizes in the shortest time (full tilt half way, full tilt back).
double time_optimal_rms_m(const std::vector<double>& steps_m, double tilt_rad, double window_s);

}  // namespace m100::lab::experiments
