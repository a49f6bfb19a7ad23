// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string_view>

#include "firmware/app/flight_controller.h"
#include "firmware/companion/ground_station/return_to_start.h"
#include "firmware/companion/operator/operator_log.h"
#include "firmware/companion/operator/pose_monitor.h"
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

/// Whether the law may take over now, and what is reported to the operator if not. No heap.
class StartConditions {
 public:
  StartConditions(const FlightRequest& request, const safety::Limits& limits,
                  const app::FlightController<double>& controller, OperatorLog& operator_log)
      : request_(request), limits_(limits), controller_(controller), operator_log_(operator_log) {}

  /// Call it once per tick. @param waits control is not ours and was not requested.
  /// @param goal_led the last flight flew to goals: the next one begins where the aircraft is, not at its course.
  void update(core::TimePoint now, bool waits, bool goal_led) {
    pose_.tick(now, controller_, waits, operator_log_);
    goal_led_ = goal_led;
  }

  /// Whether the authority table waits for the operator at this stage.
  static constexpr bool waits_for_operator(safety::AuthorityStage stage) {
    return stage == safety::AuthorityStage::kReady || stage == safety::AuthorityStage::kSilent ||
           stage == safety::AuthorityStage::kSilentCold;
  }
  /// A command would take off: the aircraft stands on the ground.
  bool on_ground(core::TimePoint now) const;
  safety::FailsafeReason denial(bool takes_off) const;  ///< why the failsafe would not let the law fly; kNone: it would
  /// No reason of the failsafe would deny control.
  bool is_clear(core::TimePoint now) const { return denial(on_ground(now)) == safety::FailsafeReason::kNone; }
  /// Control can be requested: the autopilot awaits it, and no condition here prevents it.
  bool is_ready(core::TimePoint now) const;
  /// The law must not take over here: farther from the beginning of the course than its reach, or outside the fence.
  bool is_out_of_bounds(bool takes_off) const { return is_outside(takes_off) || is_out_of_reach(takes_off); }
  /// The source of pose prevents control.
  bool pose_blocks(core::TimePoint now) const { return pose_.blocks(now); }
  bool has_rival() const { return pose_.has_rival(); }
  std::span<const ClockStep> clock_steps() const { return pose_.clock_steps(); }

  /// Reports, and returns, whether control cannot be asked for at all. @param backed_up the second process gives
  /// control back if this program dies. @param program_ends the program ends after this line.
  bool report_impossible(core::TimePoint now, bool backed_up, bool program_ends) const;
  /// Reports why the source of pose prevents control; only once unless `again`. @returns whether this report withdraws
  /// the operator's order: it does for a second sender or a wrong attitude, not for a check that only needs more time.
  bool report_pose(core::TimePoint now, bool again);
  /// @param program_ends the program ends after this line.
  void report_position(core::TimePoint now, bool takes_off, bool program_ends) const;
  void report_denial(core::TimePoint now, safety::FailsafeReason cause, bool program_ends) const;
  /// Reports an obstacle to a flight, such as a missing pose, once it has lasted while the autopilot awaits a request:
  /// otherwise the operator would wait without knowing why. @param waits as for update().
  void report_awaited(core::TimePoint now, bool waits);
  /// The time for which an obstacle has lasted counts from now.
  void restart(core::TimePoint now) { clear_ = now; }

 private:
  bool is_outside(bool takes_off) const;
  bool is_out_of_reach(bool takes_off) const;
  void add_refused_poses(TextLine& line, safety::FailsafeReason cause, core::TimePoint now) const;
  void report_distance(core::TimePoint now, bool takes_off, bool program_ends) const;

  FlightRequest request_;
  safety::Limits limits_;
  const app::FlightController<double>& controller_;
  OperatorLog& operator_log_;
  PoseMonitor pose_;
  bool pose_reported_ = false;
  bool goal_led_ = false;
  core::TimePoint clear_{};  ///< when there was last no obstacle
  safety::FailsafeReason reported_denial_ = safety::FailsafeReason::kNone;
};

}  // namespace m100::companion
