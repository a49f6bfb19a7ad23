// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <vector>

namespace m100::lab::experiments {

/// One tick of a simulated flight: true state (unknown to the controller), command and estimate. World NWU, SI.
struct TracePoint {
  double t_s = 0.0;
  std::array<double, 3> reference_m{};
  std::array<double, 3> position_m{};
  std::array<double, 3> velocity_m_s{};
  double reference_yaw_rad = 0.0;
  double yaw_rad = 0.0;
  double roll_rad = 0.0;
  double pitch_rad = 0.0;
  std::array<double, 4> applied_command{};   ///< roll, pitch, climb, yaw rate as granted by the supervisor
  std::array<double, 2> disturbance_m_s2{};  ///< x and y, as the observer estimates it
  int failsafe_state = 0;                    ///< safety::FailsafeState
  /// Normalised square of the observer's error in position and velocity of both axes: error' P^-1 error with its own
  /// covariance P, expectation 4 (Bar-Shalom). Negative: there is none.
  double nees = -1.0;
};

using Trace = std::vector<TracePoint>;

}  // namespace m100::lab::experiments
