// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "firmware/app/config.h"
#include "firmware/app/flight_controller.h"
#include "firmware/companion/files/flight_file.h"
#include "firmware/companion/files/vehicle_file.h"
#include "host_tests/lab/experiments/trace.h"
#include "host_tests/sim/ports/world.h"
#include "host_tests/sim/world/plant.h"

namespace m100::lab::experiments {

/// One simulated flight of the whole program: start-up over the wire, control obtained, course flown, control released.
struct FlightPlan {
  sim::Plant plant;
  companion::VehicleFile vehicle;  ///< what the controller believes
  std::string course;              ///< companion::lay_course, from where the aircraft hovers
  double duration_s = 0.0;         ///< from the start of the course to the order to release
  std::uint64_t seed = 1;
  link::Channel channel = link::Channel::kVirtualRc;
  double rate_hz = 0.0;  ///< of commands; 0: the default of the channel
  bool paper_100_hz = false;
  mpc::Law law = mpc::Law::kMpc;
  bool answers_swings = true;    ///< as app::FlightConfig: false flies the law alone, swing or not
  bool solves_when_due = false;  ///< as app::FlightConfig: true flies as the image does
  bool keep_log = false;         ///< ULog bytes in the result
  /// The pilot holds the aircraft at its place until control is taken, and the course begins where it is then; else his
  /// sticks rest, and it drifts with the wind. Not beside keep_log: the log's notes stand before the flight.
  bool pilot_holds_place = false;
  bool looks_first =
      false;  ///< as `m100 fly --take-control`: asks for control once the poses were held against the force
  std::optional<companion::FlightFile> flight_file;  ///< what the flight may do; none: the defaults of the program
  /// Called once, before the first tick: what is wrong from the start.
  std::function<void(sim::World&)> prepare;
  /// Called before every tick of the course with its time: faults.
  std::function<void(sim::World&, double t_s)> disturb;
  /// Called before every tick of the course with its time: the operator.
  std::function<void(app::FlightController<double>&, double t_s)> operate;
};

struct FlightResult {
  bool flew = false;                                                    ///< control was obtained and the course begun
  core::Vector<double, 3> start_w_m = core::Vector<double, 3>::Zero();  ///< where the course begins
  std::string descent;            ///< why the ladder left its top for good, in words
  double swing_noticed_s = -1.0;  ///< from the start of the course; negative: no swing was (ctl::SwingWatch)
  // What spoke while the course was flown.
  bool contradicted = false;        ///< poses or attitude were, by what else the autopilot tells
  bool left_model = false;          ///< an axis answered unlike its model (sysid::ResidualMonitor)
  std::uint32_t refused_poses = 0;  ///< the most in a row, by the observer's gate
  std::string authority;            ///< what the link last said about control, in words
  Trace trace;                      ///< one point a tick, t_s from the start of the course
  /// Of the poses that the observer used while the course was flown: see est::EkfCounters; 2 for each is right.
  double nis_sum = 0.0;
  std::uint32_t nis_count = 0;
  est::PoseTimingReport<double> pose_timing;  ///< as found at the end
  double hardest_touch_m_s = 0.0;
  double largest_tilt_deg = 0.0;
  sim::N1Record autopilot;   ///< the examiner's notes
  bool handed_over = false;  ///< at the end the pilot flies, by the protocol
  std::vector<std::uint8_t> log;
  std::uint32_t dropped_log_messages = 0;
  app::TickStats ticks;
  double seconds_of_computer = 0.0;
  /// How much older than it is the newest pose was taken for; mean of the last seconds in which poses were used.
  double pose_age_error_s = 0.0;
};

FlightResult fly(const FlightPlan& plan);

}  // namespace m100::lab::experiments
