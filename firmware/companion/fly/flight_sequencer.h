// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "firmware/app/flight_controller.h"
#include "firmware/companion/fly/autopilot_task.h"
#include "firmware/companion/fly/flight_reporter.h"
#include "firmware/companion/fly/monitor/landing_monitor.h"
#include "firmware/companion/fly/monitor/release_monitor.h"
#include "firmware/companion/fly/monitor/tracking_error.h"
#include "firmware/companion/fly/start_conditions.h"
#include "firmware/companion/ground_station/return_to_start.h"
#include "firmware/companion/operator/operator_input.h"
#include "firmware/companion/operator/operator_log.h"
#include "firmware/companion/operator/pose_monitor.h"
#include "firmware/companion/operator/text_line.h"

namespace m100::companion {

/// How an order would be treated now.
struct SequencerStatus {
  bool waits = false;             ///< a command would request control; otherwise it would give it back
  bool is_releasing = false;      ///< control goes back: a command has no effect
  bool on_ground = false;         ///< a command would take off first
  bool may_land = false;          ///< an order to land would be served
  bool takes_off = false;         ///< the autopilot takes off, or control is requested for it
  bool lands = false;             ///< the autopilot lands
  bool returns_to_start = false;  ///< the battery is low, and the aircraft flies to where the flight began, or is there
};

/// The operator's part of a flight (promise R15). A command takes control when everything is ready. The next command,
/// or a signal, gives control back and ends the program. The end waits until control cannot be ours any more, the port
/// is gone for good, or further signals insist. After a refusal, a release by the failsafe or a landing that the
/// autopilot began by itself the program waits for the next command; with --once it ends. A take-off precedes the
/// flight and a landing follows it, each only if it is ordered. A command, a signal and the pilot's switch end them as
/// they end a flight; if the autopilot refuses a take-off or a landing, control goes back. Instead of a landing that
/// would drift with the wind the law hovers for ten seconds, in which the pilot is told to land by hand, then control
/// goes back. No heap.
class FlightSequencer {
 public:
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
        reporter_(controller, config.limits, request.land, operator_log),
        start_(request, config.limits, controller, operator_log),
        task_(config.fence, request.ground_z_m),
        release_monitor_(operator_log) {}

  /// Call it after each tick. @returns false: the program ends.
  bool tick(core::TimePoint now, const OperatorInput& input);

  bool flew() const { return outcome_.flew; }
  SequencerStatus status(core::TimePoint now) const;
  bool took_off() const { return outcome_.took_off; }
  bool landed() const { return outcome_.landed; }
  /// We had control, gave it back by order, at the end of --hold or after a landing, and the transmitter has it.
  bool given_back() const { return outcome_.given_back; }
  /// What happened so far.
  const FlightReporter& reporter() const { return reporter_; }
  std::span<const ClockStep> clock_steps() const { return start_.clock_steps(); }

 private:
  /// kHovering: in place of a landing that the wind would carry away, until the pilot lands.
  enum class Phase { kWaiting, kRequesting, kTask, kFlying, kHovering, kReleasing };
  using View = link::AuthorityView;
  /// What a flight was, for its result.
  struct Outcome {
    bool flew = false;
    bool took_off = false;
    bool landed = false;
    bool given_back = false;
    bool hovered = false;  ///< a flight has ended with kHovering: the next ones begin where the aircraft is
  };

  void enter(Phase phase, core::TimePoint now) {
    phase_ = phase;
    since_ = now;
  }
  void end_or_continue(core::TimePoint now, const OperatorInput& input);
  /// An order to land would be served.
  bool may_land() const;
  bool returns_to_start() const { return home_.state() != ReturnToStart<double>::State::kInactive; }
  bool wait(core::TimePoint now, const View& view, const OperatorInput& input);
  /// @returns true: with --once, because control was refused or was not possible within 20 s. Reports the latter.
  bool ends_without_flight(core::TimePoint now, const View& view);
  bool request_control(core::TimePoint now, const View& view, const OperatorInput& input);
  bool fly(core::TimePoint now, const View& view, const OperatorInput& input);
  bool fly_task(core::TimePoint now, const View& view, const OperatorInput& input);
  void begin_task(core::TimePoint now, protocol::Task task);
  void end_task(core::TimePoint now, const OperatorInput& input);
  bool hover(core::TimePoint now, const View& view, const OperatorInput& input);
  /// The autopilot lands by itself: reports it and gives control back.
  bool ends_by_landing(core::TimePoint now, const OperatorInput& input);
  bool release_control(core::TimePoint now, const View& view, const OperatorInput& input);
  void try_to_engage(core::TimePoint now, bool backed_up);
  /// With --once, a refusal to carry out the program's own order to take control ends the program.
  bool ends_on_denial() const { return order_given_ && request_.once; }
  void begin_release(core::TimePoint now, bool by_operator, const OperatorInput& input);
  void give_back(core::TimePoint now, bool by_operator, const OperatorInput& input);
  bool is_refused(core::TimePoint now, const View& view) const {
    return now > since_ && !view.control_requested && StartConditions::waits_for_operator(view.stage);
  }
  /// Control is not ours any more. @returns true
  bool end_by_loss(core::TimePoint now, const View& view, const OperatorInput& input);
  void report(core::TimePoint now, std::string_view what) { operator_log_.write(now, what); }

  FlightRequest request_;
  safety::Limits limits_;
  app::FlightController<double>& controller_;
  OperatorLog& operator_log_;
  ReturnToStart<double> home_;
  FlightReporter reporter_;
  StartConditions start_;
  AutopilotTask task_;
  Phase phase_ = Phase::kWaiting;
  core::TimePoint since_{};  ///< begin of the phase
  LandingMonitor landing_monitor_;
  ReleaseMonitor release_monitor_;
  bool takes_off_ = false;    ///< the flight that was requested begins with a take-off
  bool had_control_ = false;  ///< since the last request
  bool order_given_ = false;  ///< take_control's one order to fly was given, or was withdrawn before
  bool engaged_ = false;      ///< the law flew in this flight
  bool by_operator_ = false;
  bool ends_ = false;  ///< the program ends when the hand-back is over
  Outcome outcome_;
  std::optional<core::TimePoint> waits_since_;  ///< for start-up, or for an obstacle to go away
};

}  // namespace m100::companion
