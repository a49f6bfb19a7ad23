// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "firmware/app/config.h"
#include "firmware/app/flight_controller.h"
#include "firmware/app/vehicle_file.h"
#include "host_tests/sim/plant.h"
#include "host_tests/sim/world.h"
#include "host_tests/tools/experiments/trace.h"

namespace m100::tools::experiments {

/// One simulated flight of the whole program: start-up over the wire, control obtained, course flown, control released.
struct FlightPlan {
  sim::Plant plant;
  app::VehicleFile vehicle;  ///< what the controller believes
  std::string course;        ///< app::lay_course, from where the aircraft hovers
  double duration_s = 0.0;   ///< from the start of the course to the order to release
  std::uint64_t seed = 1;
  app::Channel channel = app::Channel::kVirtualRc;
  double rate_hz = 0.0;  ///< of commands; 0: the default of the channel
  bool paper_100_hz = false;
  bool keep_log = false;  ///< ULog bytes in the result
  /// Called before every tick of the course with its time: faults.
  std::function<void(sim::World&, double t_s)> disturb;
};

struct FlightResult {
  bool flew = false;  ///< control was obtained and the course begun
  Trace trace;        ///< one point a tick, t_s from the start of the course
  double hardest_touch_m_s = 0.0;
  double largest_tilt_deg = 0.0;
  sim::N1Record autopilot;   ///< the examiner's notes
  bool handed_over = false;  ///< at the end the pilot flies, by the protocol
  std::vector<std::uint8_t> log;
  std::uint32_t dropped_log_messages = 0;
  app::TickStats ticks;
  double seconds_of_computer = 0.0;
};

FlightResult fly(const FlightPlan& plan);

}  // namespace m100::tools::experiments
