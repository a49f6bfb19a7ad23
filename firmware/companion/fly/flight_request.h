// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>

#include "firmware/companion/ground_station/return_to_start.h"
#include "firmware/core/eigen.h"

namespace m100::companion {

/// What the operator wants of a flight.
struct FlightRequest {
  bool take_control = false;  ///< request control once, as soon as everything is ready
  double hold_s = 5.0;        ///< with take_control: after this time give back and end
  bool once = false;          ///< for scripts: end where the program would wait for the operator
  bool take_off = false;      ///< a command to fly, given on the ground, takes off first, by the autopilot's own task
  bool land = false;          ///< after hold_s or a return to the start: land by the autopilot's task, not release
  core::Vector<double, 3> course_start_w_m =
      core::Vector<double, 3>::Zero();  ///< where the course begins, in the world
  /// Where the aircraft stands before a take-off.
  core::Vector<double, 3> takeoff_position_w_m = core::Vector<double, 3>::Zero();
  double ground_z_m = 0.0;            ///< height of the ground in the world, for a landing without a take-off before it
  double max_start_distance_m = 1e9;  ///< farther from the beginning of course or take-off, control is not taken
  ReturnSettings home{};              ///< a low battery ends the flight where its course begins
  double home_yaw_rad = 0.0;
};

/// The end of a line that says why control is not taken now: what the operator may do next.
constexpr std::string_view next_input(bool program_ends) {
  return program_ends ? "--once: the program ends; start it again to ask for control again"
                      : "Enter (or SIGUSR1) asks for control again, Ctrl-C ends the program";
}

}  // namespace m100::companion
