// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>

#include "host_tests/sim/world/vehicle_port.h"

namespace m100::sim {

/// y'' = w^2 (a + zero a' - y) - 2 z w y', a the command of delay_s ago, as model::StickAxis.
struct SecondOrder {
  double frequency_rad_s = 0.0;
  double damping_ratio = 0.0;
};

/// The second order whose response to a step of size 1 is nearest to these samples (least squares).
SecondOrder fit_step(std::span<const double> samples, double step_s, double delay_s, double zero_s);

/// Gives a hovering body a step of roll, pitch and climb, flies it back, and compares what it did with the measured
/// flights: the sentence has frequency and damping of each axis, and how far they lie outside the measured intervals.
std::string compare_response(VehiclePort& body, const core::Vector<double, 3>& place_w_m);

}  // namespace m100::sim
