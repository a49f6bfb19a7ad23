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
#include "firmware/ref/trajectory.h"
#include "host_tests/lab/experiments/trace.h"
#include "host_tests/sim/body/body_choice.h"
#include "host_tests/sim/ports/world.h"
#include "host_tests/sim/world/plant.h"

namespace m100::lab::experiments {

/// One simulated flight of the whole program: start-up over the wire, control obtained, course flown, control released.
struct FlightPlan {
  sim::Plant plant;
  companion::VehicleFile vehicle;  ///< vehicle file of the controller
  std::string course;              ///< companion::parse_course, relative to where the aircraft hovers
  double duration_s = 0.0;         ///< from the start of the course to the order to release
  std::uint64_t seed = 1;
  link::Channel channel = link::Channel::kVirtualRc;
  double rate_hz = 0.0;  ///< command rate; 0: the default of the channel
  bool paper_100_hz = false;
  mpc::Law law = mpc::Law::kMpc;
  bool responds_to_limit_cycles = true;  ///< as app::FlightConfig; false: the law flies on even if it oscillates
  bool plans_setpoints = true;           ///< as app::FlightConfig
  bool paper_law = false;                ///< as app::FlightConfig
  bool solves_when_due = false;          ///< as app::FlightConfig; true: as the firmware image flies
  bool keep_log = false;                 ///< ULog bytes in the result
  /// The pilot holds the aircraft in place until control is taken, and the course begins there. Otherwise his sticks
  /// rest, and the aircraft drifts with the wind.
  bool pilot_holds_position = false;
  /// Where the course begins. A log needs it if the pilot holds the position, because its notes are written before the
  /// flight. None: see pilot_holds_position.
  std::optional<ref::Waypoint<double>> start;
  bool checks_poses_first =
      false;  ///< as `m100 fly --take-control`: requests control once the poses were checked against the force
  sim::BodyJob* body =
      nullptr;  ///< makes the aircraft, whose pilot then holds the position; null: the identified response
  std::optional<companion::FlightFile> flight_file;  ///< limits of the flight; none: the program's defaults
  ctl::ExcitationPlan excitation{};  ///< flown at the start of the course; what it views must outlive the flight
  /// Called once, before the first tick: faults that exist from the start.
  std::function<void(sim::World&)> prepare;
  /// Called before every tick of the course with the time since its start: faults.
  std::function<void(sim::World&, double t_s)> disturb;
  /// Called before every tick of the course with the time since its start: the operator's actions.
  std::function<void(app::FlightController<double>&, double t_s)> operate;
};

struct FlightResult {
  bool flew = false;            ///< control was obtained and the course was started
  ref::Waypoint<double> start;  ///< where the course began
  std::string descent;          ///< why the failsafe last left nominal, or coast before its time-out, in words
  double limit_cycle_detected_s =
      -1.0;  ///< from the start of the course; negative: no oscillation (ctl::LimitCycleDetector)
  // Alarms while the course was flown.
  std::uint32_t fence_stops = 0;    ///< ctl::GeofenceStatus::stops
  bool contradicted = false;        ///< poses or attitude disagreed with other data of the autopilot
  bool model_mismatch = false;      ///< an axis did not follow its model (sysid::ResidualMonitor)
  std::uint32_t refused_poses = 0;  ///< largest number in a row that the observer's gate refused
  std::string authority;            ///< the link's last statement about control, in words
  Trace trace;                      ///< one point a tick, t_s from the start of the course
  /// Sum of the normalised squared innovations of the poses used during the course; the expectation is 2 for each.
  double nis_sum = 0.0;
  std::uint32_t nis_count = 0;
  est::PoseTimingReport<double> pose_timing;  ///< as found at the end
  double touchdown_speed_m_s = 0.0;
  double largest_tilt_deg = 0.0;
  sim::N1Record autopilot;   ///< the emulated autopilot's record of the flight
  bool handed_over = false;  ///< at the end the pilot flies, according to the autopilot
  std::vector<std::uint8_t> log;
  std::uint32_t dropped_log_messages = 0;
  app::TickStats ticks;
  double computer_time_s = 0.0;
  double simulated_s = 0.0;  ///< the world's time at the end
  /// Estimated minus true age of the newest pose; exponential mean (memory 1 s) over the ticks with fresh poses.
  double pose_age_error_s = 0.0;
};

/// `plan` with the law of the paper's authors: model::paper_configuration(), app::FlightConfig::paper_law, no reaction
/// to a limit cycle, and 100 commands a second unless the plan has a rate.
FlightPlan in_paper_configuration(FlightPlan plan);

/// @throws sim::PhysicsError a body's physics program fails.
FlightResult fly(const FlightPlan& plan);

}  // namespace m100::lab::experiments
