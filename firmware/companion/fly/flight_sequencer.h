// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "firmware/app/flight_controller.h"
#include "firmware/companion/fly/autopilot_task.h"
#include "firmware/companion/fly/release_monitor.h"
#include "firmware/companion/fly/tracking_error.h"
#include "firmware/companion/ground_station/return_to_start.h"
#include "firmware/companion/operator/operator_log.h"
#include "firmware/companion/operator/pose_monitor.h"
#include "firmware/companion/operator/text_line.h"

namespace m100::companion {

/// What the operator wants of a flight.
struct FlightRequest {
  bool take_control = false;  ///< request control once, as soon as everything is ready
  double hold_s = 5.0;        ///< with take_control: after this time give back and end
  bool once = false;          ///< for scripts: end where the program would wait for the operator
  bool take_off = false;      ///< a command to fly, given on the ground, takes off first, by the autopilot's own task
  bool land = false;          ///< land at the end of hold_s, likewise, instead of giving control back in the air
  core::Vector<double, 3> course_start_w_m =
      core::Vector<double, 3>::Zero();  ///< where the course begins, in the world
  /// Where the aircraft stands before a take-off.
  core::Vector<double, 3> takeoff_position_w_m = core::Vector<double, 3>::Zero();
  double max_start_distance_m =
      1e9;                ///< control is not requested farther from there: the law would fly the distance at once
  ReturnSettings home{};  ///< a low battery ends the flight where its course begins
  double home_yaw_rad = 0.0;
};

/// What the operator did since the last tick.
struct SequencerInput {
  bool toggle_control = false;  ///< Enter, or SIGUSR1
  bool land = false;            ///< "land", typed, or by a signed order
  std::uint32_t stops = 0;      ///< signals to end, so far
  bool backed_up = true;        ///< the second process gives control back if this program dies
  bool goal_led =
      false;  ///< goals have led the flight: the next flight begins where the aircraft is, not at its course
};

/// The operator's part of a flight (promise R15). One command takes control when everything is ready, another gives it
/// back. A refusal or a release by the failsafe does not end the program: it tells what was seen and waits for the
/// operator's next command. The program ends only when telemetry shows that the transmitter has the aircraft, or when
/// the port is gone. A take-off precedes the flight and a landing follows it, each only on its own order. A command, a
/// stop and the pilot's switch end them as they end a flight; if the autopilot refuses one, control goes back. No heap.
class FlightSequencer {
 public:
  static constexpr std::size_t kMaxTransitions = 64;  ///< steps of the failsafe that are kept: the first ones

  /// @param trajectory the controller's: a low battery changes it.
  FlightSequencer(const FlightRequest& request, const app::FlightConfig& config,
                  app::FlightController<double>& controller, ref::Trajectory<double>& trajectory,
                  OperatorLog& operator_log)
      : request_(request),
        limits_(config.limits),
        controller_(controller),
        operator_log_(operator_log),
        home_(trajectory, config.fence, {.position_w_m = request.course_start_w_m, .yaw_rad = request.home_yaw_rad},
              request.home),
        release_monitor_(operator_log) {}

  /// Call it after each tick. @returns false: the flight is over.
  bool tick(core::TimePoint now, const SequencerInput& input);

  bool flew() const { return flew_; }
  /// Control was not requested: a command would request it.
  bool waits() const { return phase_ == Phase::kWaiting; }
  /// A command would have no effect.
  bool is_releasing() const { return phase_ == Phase::kReleasing; }
  /// A command would take off: control is not ours, and the aircraft stands on the ground.
  bool engage_takes_off(core::TimePoint now) const { return waits() && starts_on_ground(now); }
  void end_or_continue(core::TimePoint now, const SequencerInput& input);
  /// An order to land would be served.
  bool may_land() const;
  /// A take-off or landing by the autopilot is in progress, or control is requested for a take-off.
  bool in_task(protocol::Task task) const {
    const bool is_asked_for = phase_ == Phase::kRequesting && takes_off_ && task == protocol::Task::kTakeOff;
    return is_asked_for || (phase_ == Phase::kTask && task_.task() == task);
  }
  /// The battery is low, and the aircraft flies to where the flight began, or is there.
  bool returns_to_start() const { return home_.state() != ReturnToStart<double>::State::kInactive; }
  bool took_off() const { return took_off_; }
  bool landed() const { return landed_; }
  /// Control was ours, the operator ended it, and the transmitter has the aircraft.
  bool given_back() const { return given_back_; }
  /// The observation when the first swing was noticed (safety::Observation::swings); empty: none was.
  const std::optional<safety::Observation>& limit_cycle() const { return limit_cycle_; }
  std::span<const ClockStep> clock_steps() const { return pose_.clock_steps(); }
  const TrackingError& tracking() const { return tracking_; }
  std::span<const safety::FailsafeStep> steps() const { return std::span(steps_).first(step_count_); }

 private:
  enum class Phase { kWaiting, kRequesting, kTask, kFlying, kReleasing };
  using View = link::AuthorityView;
  static constexpr std::string_view kRequestAgain =
      "Enter (or SIGUSR1) asks for control again, Ctrl-C ends the program";
  static constexpr std::string_view kProgramEnds = "--once: the program ends; start it again to ask for control again";

  bool wait(core::TimePoint now, const View& view, const SequencerInput& input);
  bool request_control(core::TimePoint now, const View& view, const SequencerInput& input);
  bool fly(core::TimePoint now, const View& view, const SequencerInput& input);
  bool fly_task(core::TimePoint now, const View& view, const SequencerInput& input);
  void begin_task(core::TimePoint now, protocol::Task task);
  void end_task(core::TimePoint now, const SequencerInput& input);
  bool release_control(core::TimePoint now, const View& view, const SequencerInput& input);
  void try_to_engage(core::TimePoint now, bool backed_up);
  bool starts_on_ground(core::TimePoint now) const;
  safety::FailsafeReason denial_now(bool takes_off) const;
  bool is_outside(bool takes_off) const;
  bool is_out_of_reach(bool takes_off) const;
  /// The law must not take over here: farther from the beginning of the course than its reach, or outside the fence.
  bool is_out_of_bounds(bool takes_off) const { return is_outside(takes_off) || is_out_of_reach(takes_off); }
  /// What the operator may do next; ends a line that says why control is not taken now.
  std::string_view next_input(bool ends_with_once) const {
    return ends_with_once && request_.once ? kProgramEnds : kRequestAgain;
  }
  void report_distance(core::TimePoint now, bool takes_off);
  void report_position(core::TimePoint now, bool takes_off);
  void report_denial(core::TimePoint now, safety::FailsafeReason cause);
  void begin_release(core::TimePoint now, bool by_operator, const SequencerInput& input);
  bool is_refused(core::TimePoint now, const View& view) const;
  void report_stage(core::TimePoint now, const View& view);
  void report_failsafe(core::TimePoint now);
  void report_excitation(core::TimePoint now);
  void report_limit_cycle(core::TimePoint now);
  void report_return(core::TimePoint now);
  void report_end(core::TimePoint now, const View& view);
  void tell_tracking(core::TimePoint now);
  void add_refused_poses(TextLine& line, safety::FailsafeReason cause, core::TimePoint now) const;
  void note_flight();
  void refuse_for_pose(core::TimePoint now);
  void report_awaited(core::TimePoint now, const View& view);
  void report(core::TimePoint now, std::string_view what) { operator_log_.write(now, what); }

  FlightRequest request_;
  safety::Limits limits_;
  app::FlightController<double>& controller_;
  OperatorLog& operator_log_;
  ReturnToStart<double> home_;
  ReturnToStart<double>::State reported_return_ = ReturnToStart<double>::State::kInactive;
  AutopilotTask task_;
  Phase phase_ = Phase::kWaiting;
  core::TimePoint since_{};  ///< begin of the phase
  ReleaseMonitor release_monitor_;
  PoseMonitor pose_;
  TrackingError tracking_;
  bool tracking_said_ = false;
  bool trial_said_ = false;
  safety::Observation worst_;  ///< the largest ages and distances since the law flew
  bool takes_off_ = false;     ///< the flight that was requested begins with a take-off
  bool had_control_ = false;   ///< since the last request
  bool order_given_ = false;   ///< the order of take_control
  bool engaged_ = false;       ///< the law flew in this flight
  bool by_operator_ = false;
  bool goal_led_ = false;  ///< SequencerInput::led of this tick
  bool ends_ = false;      ///< the program ends when the hand-back is over
  bool flew_ = false;
  bool took_off_ = false;
  bool landed_ = false;
  bool given_back_ = false;
  core::TimePoint clear_{};                     ///< when only the operator's command was missing
  std::optional<core::TimePoint> waits_since_;  ///< for start-up, or for an obstacle to go away
  safety::FailsafeReason reported_denial_ = safety::FailsafeReason::kNone;
  bool reported_stage_ = false;
  ctl::Excitation<double>::State reported_excitation_ = ctl::Excitation<double>::State::kIdle;
  bool limit_cycle_reported_ = false;
  std::optional<safety::Observation> limit_cycle_;
  safety::AuthorityStage last_stage_ = safety::AuthorityStage::kListening;
  safety::AuthorityReason last_reason_ = safety::AuthorityReason::kNone;
  std::uint32_t reported_transitions_ = 0;
  std::array<safety::FailsafeStep, kMaxTransitions> steps_{};
  std::size_t step_count_ = 0;
};

}  // namespace m100::companion
