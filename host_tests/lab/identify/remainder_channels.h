// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "host_tests/lab/logs/flight_log.h"

namespace m100::lab::identify {

/// The response that a model leaves, in rows that are a constant time apart within a segment.
struct RemainderInput {
  std::string direction{};      ///< of motion: "" or "x", ...
  double row_s = 0.05;          ///< between rows
  std::vector<double> t_s{};    ///< of each row, ascending within a segment
  std::vector<double> error{};  ///< measured minus model
  std::vector<double> model{};  ///< simulated response
  double slope_s = 0.0;         ///< the inverse dynamics are 1 + slope_s d/dt + curvature_s2 d^2/dt^2
  double curvature_s2 = 0.0;    ///< both are zero where the error is an acceleration already
  double stick_delay_s = 0.0;   ///< of the model: so late do the sticks act
  std::string stick{};          ///< of the axis: its rate is a channel, too; empty: none
  std::string response{};       ///< of the axis: model and its rate are channels; empty: they are not
  std::string rate{};           ///< measured response and rate are no channels, because they move with the error
};

/// One channel at every row.
struct Channel {
  std::string name;
  std::string unit;  ///< empty: unknown
  std::vector<double> values;
};

/// Time, sticks, attitude, rates, position and velocity of the log and its extra channels, as means over a row. The
/// heading is wrapped; horizontal speeds are along and across it, because air acts on the body.
std::vector<Channel> channels_of(const logs::FlightLog& log, const RemainderInput& input);

}  // namespace m100::lab::identify
