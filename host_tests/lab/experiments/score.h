// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "host_tests/lab/experiments/trace.h"

namespace m100::lab::experiments {

/// Root mean squares over a window, as in the paper's results table (IV-C: pose by Euclidean distance; roll and pitch
/// themselves, not their errors), and values that the table does not have.
struct Cell {
  double pose_m = 0.0;
  double x_m = 0.0;
  double y_m = 0.0;
  double z_m = 0.0;
  double roll_deg = 0.0;
  double pitch_deg = 0.0;
  double yaw_deg = 0.0;
  double tilt_deg = 0.0;               ///< tilt of the thrust axis
  double input_variation_deg_s = 0.0;  ///< summed change of both tilt commands per second
  double worst_m = 0.0;                ///< largest distance from the reference
  double off_nominal_share = 0.0;      ///< share of the ticks in which the failsafe was not nominal
};

/// Root mean squares over [from, to) seconds. An empty window gives zeros.
Cell score(const Trace& trace, double from_s, double to_s);

/// Whether the flight was flown, always in the state nominal or coast. An empty trace did not stay.
bool stayed(const Trace& trace);

/// Mean over flights, and sample standard deviation, for each field.
Cell mean_of(const std::vector<Cell>& cells);
Cell spread_of(const std::vector<Cell>& cells);
/// The value below which the share of the flights lies, for each field; linear between two flights, zeros for none.
Cell quantile_of(const std::vector<Cell>& cells, double share);

/// A field of a Cell with its name in JSON and tables.
struct CellField {
  const char* name;
  double Cell::*member;
};
const std::vector<CellField>& cell_fields();

/// Lower bound of the horizontal RMS: root mean square, over a window of `window_s`, of the remaining distance of a
/// vehicle that tilts instantly, by at most `tilt_rad`, and covers steps of these sizes in the shortest time (full tilt
/// for the first half, full opposite tilt for the second).
double time_optimal_rms_m(const std::vector<double>& steps_m, double tilt_rad, double window_s);

}  // namespace m100::lab::experiments
