// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/fly/flight_sequencer.h"

#include "firmware/companion/operator/operator_messages.h"

namespace m100::companion {
namespace {

using Excitation = ctl::Excitation<double>;

/// As long as an order to fly is valid in the flight controller: after a later grant nothing would fly.
constexpr core::Duration kRequestTimeout = std::chrono::seconds(20);

constexpr core::Duration kHover = std::chrono::seconds(10);  ///< in place of a landing

constexpr std::string_view kNoLanding = "landing is not ordered: the program does not fly the aircraft";

}  // namespace

bool FlightSequencer::tick(core::TimePoint now, const OperatorInput& input) {
  const link::SerialLink& link = controller_.link();
  const View& view = link.authority();
  reporter_.update(now, phase_ == Phase::kFlying || phase_ == Phase::kHovering);
  home_.update(controller_, now);
  reporter_.update_return(home_, now);
  release_monitor_.update(now, view);
  landing_monitor_.update(link.telemetry().flight_status, link.received_at(protocol::TelemetryItem::kFlightStatus));
  start_.update(now, phase_ == Phase::kWaiting, input.goal_led || outcome_.hovered);
  if (input.land && (phase_ == Phase::kWaiting || phase_ == Phase::kRequesting || phase_ == Phase::kReleasing)) {
    report(now, kNoLanding);
  }
  switch (phase_) {
    case Phase::kWaiting:
      return wait(now, view, input);
    case Phase::kRequesting:
      return request_control(now, view, input);
    case Phase::kTask:
      return fly_task(now, view, input);
    case Phase::kFlying:
      return fly(now, view, input);
    case Phase::kHovering:
      return hover(now, view, input);
    case Phase::kReleasing:
      return release_control(now, view, input);
  }
  return false;
}

SequencerStatus FlightSequencer::status(core::TimePoint now) const {
  const bool waits = phase_ == Phase::kWaiting;
  const bool is_landing = task_.task() == protocol::Task::kLand;
  return {.waits = waits,
          .is_releasing = phase_ == Phase::kReleasing,
          .on_ground = waits && start_.on_ground(now),
          .may_land = may_land(),
          .takes_off = (phase_ == Phase::kRequesting && takes_off_) || (phase_ == Phase::kTask && !is_landing),
          .lands = phase_ == Phase::kTask && is_landing,
          .returns_to_start = returns_to_start()};
}

bool FlightSequencer::wait(core::TimePoint now, const View& view, const OperatorInput& input) {
  if (input.stops > 0) {
    if (!view.release_pending) {
      return false;
    }
    begin_release(now, false, input);
    return true;
  }
  // take_control acts once, in the first tick in which everything is ready. An operator's command is tried at once.
  const bool all_ready = start_.is_ready(now);
  if (request_.take_control && !order_given_ && all_ready && controller_.is_converged()) {
    order_given_ = true;
    try_to_engage(now, input.backed_up);
  } else if (input.toggle_control) {
    try_to_engage(now, input.backed_up);
  }
  start_.report_awaited(now, phase_ == Phase::kWaiting);
  waits_since_ = all_ready || phase_ != Phase::kWaiting ? now : waits_since_.value_or(now);
  const bool is_looked_at = start_.is_clear(now) && controller_.is_converged();
  if (request_.take_control && !order_given_ && start_.pose_blocks(now) && (is_looked_at || start_.has_rival())) {
    order_given_ = start_.report_pose(now, false);
  }
  return !ends_without_flight(now, view);
}

bool FlightSequencer::ends_without_flight(core::TimePoint now, const View& view) {
  // Control was refused, or the reason why it cannot be requested does not go away by itself, or did not within 20 s.
  const bool has_waited = request_.take_control && now - *waits_since_ > kRequestTimeout;
  const bool stuck = view.stage == safety::AuthorityStage::kSilent ||
                     view.stage == safety::AuthorityStage::kSilentCold || order_given_ || has_waited;
  const bool ends =
      request_.once && phase_ == Phase::kWaiting && stuck && !view.control_requested && !view.release_pending;
  if (ends && view.stage != safety::AuthorityStage::kReady && has_waited) {
    reporter_.report_refusal(now, "control could not be asked for within 20 s: ", view);
  }
  return ends;
}

void FlightSequencer::try_to_engage(core::TimePoint now, bool backed_up) {
  if (start_.report_impossible(now, backed_up, ends_on_denial())) {
    return;
  }
  if (start_.pose_blocks(now)) {
    const bool is_used_up = start_.report_pose(now, true);
    order_given_ = order_given_ || is_used_up;
    return;
  }
  takes_off_ = start_.on_ground(now);
  const safety::FailsafeReason cause = start_.denial(takes_off_);
  // Other reasons do not refuse the order: before the first telemetry, for example, it waits for start-up.
  if (cause == safety::FailsafeReason::kPoseRefused || cause == safety::FailsafeReason::kPoseOld ||
      cause == safety::FailsafeReason::kVibration) {
    start_.report_denial(now, cause, ends_on_denial());
    return;
  }
  if (start_.is_out_of_bounds(takes_off_)) {
    start_.report_position(now, takes_off_, ends_on_denial());
    return;
  }
  controller_.engage();
  release_monitor_.control_requested(controller_.link().health().outages);
  had_control_ = false;
  outcome_.landed = false;
  enter(Phase::kRequesting, now);
}

bool FlightSequencer::request_control(core::TimePoint now, const View& view, const OperatorInput& input) {
  const bool elsewhere = start_.is_out_of_bounds(takes_off_);
  if (view.in_control && !elsewhere) {
    enter(Phase::kFlying, now);
    outcome_.flew = true;
    had_control_ = true;
    engaged_ = false;
    if (takes_off_) {
      begin_task(now, protocol::Task::kTakeOff);
    }
    return true;
  }
  if (takes_off_) {
    controller_.task_flies(false);  // if control is granted in the next tick, the law must not fly
  }
  const bool takes_it_back = now > since_ && (input.stops > 0 || input.toggle_control);
  if (takes_it_back || elsewhere || !input.backed_up || now - since_ > kRequestTimeout) {
    if (elsewhere) {
      start_.report_position(now, takes_off_, ends_on_denial());
    } else if (!takes_it_back && input.backed_up) {
      report(now, "control was not granted within 20 s");
    }
    give_back(now, takes_it_back, input);  // a request may already be granted
  } else if (is_refused(now, view)) {
    reporter_.report_refusal(now, "refused: ", view, next_input(request_.once));
    begin_release(now, false, input);
  }
  return true;
}

bool FlightSequencer::fly(core::TimePoint now, const View& view, const OperatorInput& input) {
  engaged_ = engaged_ || safety::passes_law(controller_.supervisor().failsafe_state());
  if (!view.in_control) {
    return end_by_loss(now, view, input);
  }
  if (!engaged_ && !takes_off_ &&
      start_.is_out_of_bounds(false)) {  // control was granted while the position was unknown
    start_.report_position(now, false, ends_on_denial());
    give_back(now, false, input);
    return true;
  }
  if (ends_by_landing(now, input)) {
    return true;
  }
  const Excitation::State excitation = controller_.excitation().state();
  if (excitation == Excitation::State::kReturning || excitation == Excitation::State::kMoving) {
    since_ = now;  // --hold counts from the end of the excitation
  }
  end_or_continue(now, input);
  return true;
}

bool FlightSequencer::ends_by_landing(core::TimePoint now, const OperatorInput& input) {
  if (landing_monitor_.lands()) {
    reporter_.report_landing(now);
    give_back(now, false, input);
  }
  return landing_monitor_.lands();
}

void FlightSequencer::end_or_continue(core::TimePoint now, const OperatorInput& input) {
  const bool at_home = home_.state() == ReturnToStart<double>::State::kArrived;
  const bool is_held = request_.take_control && core::seconds<double>(now - since_) >= request_.hold_s;
  const bool is_over = at_home || (is_held && !returns_to_start());
  const bool ends = is_over && !(request_.land && may_land());
  if (input.stops > 0 || input.toggle_control || ends) {
    give_back(now, !at_home, input);
  } else if (may_land() && (input.land || is_over)) {
    begin_task(now, protocol::Task::kLand);
  } else if (input.land) {
    report(now, kNoLanding);
  }
}

bool FlightSequencer::end_by_loss(core::TimePoint now, const View& view, const OperatorInput& input) {
  const bool on_ground = takes_off_ && phase_ == Phase::kTask;
  const auto denial = engaged_ ? std::nullopt : std::optional(start_.denial(on_ground));
  reporter_.report_end(now, view, denial, takes_off_, next_input(request_.once));
  begin_release(now, false, input);
  return true;
}

bool FlightSequencer::may_land() const {
  const safety::FailsafeState state = controller_.supervisor().failsafe_state();
  const bool is_ours = phase_ == Phase::kFlying || phase_ == Phase::kTask || phase_ == Phase::kHovering;
  return is_ours && state != safety::FailsafeState::kRelease && state != safety::FailsafeState::kSilent;
}

void FlightSequencer::begin_release(core::TimePoint now, bool by_operator, const OperatorInput& input) {
  reporter_.report_tracking(now);
  enter(Phase::kReleasing, now);
  release_monitor_.begin(now, input.stops);
  by_operator_ = by_operator;
  outcome_.given_back = false;
  ends_ = by_operator || request_.once || input.stops > 0;
}

void FlightSequencer::give_back(core::TimePoint now, bool by_operator, const OperatorInput& input) {
  controller_.release();
  begin_release(now, by_operator, input);
}

bool FlightSequencer::release_control(core::TimePoint now, const View& view, const OperatorInput& input) {
  ends_ = ends_ || input.stops > 0;
  if (now > since_ && view.in_control && controller_.supervisor().failsafe_state() == safety::FailsafeState::kSilent) {
    controller_.release();  // again: a delayed answer may have granted control meanwhile
  }
  switch (release_monitor_.confirm_release(now, controller_.link(), input.stops)) {
    case ReleaseMonitor::State::kPending:
      return true;
    case ReleaseMonitor::State::kAbandoned:
      return !ends_;
    case ReleaseMonitor::State::kReleased:
      break;
  }
  outcome_.given_back = by_operator_ && had_control_ && release_monitor_.pilot_in_control();
  phase_ = Phase::kWaiting;
  start_.restart(now);
  return !ends_;
}

void FlightSequencer::begin_task(core::TimePoint now, protocol::Task task) {
  phase_ = Phase::kTask;
  task_.start(task, now);
  controller_.task_flies(task == protocol::Task::kLand);
  reporter_.report_task(now, task_);
}

bool FlightSequencer::fly_task(core::TimePoint now, const View& view, const OperatorInput& input) {
  if (!view.in_control) {
    return end_by_loss(now, view, input);
  }
  if (input.stops > 0 || input.toggle_control) {
    if (task_.is_flown()) {
      controller_.end_task();
    }
    give_back(now, true, input);
    return true;
  }
  if (input.land && task_.task() == protocol::Task::kTakeOff) {
    begin_task(now, protocol::Task::kLand);
  }
  switch (task_.tick(now, controller_)) {
    case AutopilotTask::State::kDone:
      end_task(now, input);
      break;
    case AutopilotTask::State::kWouldDrift:
      reporter_.report_task(now, task_);
      controller_.hover_here();
      outcome_.hovered = true;
      engaged_ = false;
      enter(Phase::kHovering, now);
      break;
    case AutopilotTask::State::kFailed:
      reporter_.report_task(now, task_);
      give_back(now, false, input);
      break;
    default:
      break;
  }
  return true;
}

void FlightSequencer::end_task(core::TimePoint now, const OperatorInput& input) {
  const bool outside = start_.denial(false) == safety::FailsafeReason::kFenceLeft;
  reporter_.report_task(now, task_, outside);
  if (task_.task() == protocol::Task::kLand) {
    outcome_.landed = true;
    give_back(now, true, input);
    return;
  }
  outcome_.took_off = true;
  if (!outside) {  // otherwise the failsafe brakes and gives control back
    controller_.engage();
  }
  enter(Phase::kFlying, now);  // --hold counts from where the law takes over
}

bool FlightSequencer::hover(core::TimePoint now, const View& view, const OperatorInput& input) {
  engaged_ = engaged_ || safety::passes_law(controller_.supervisor().failsafe_state());
  const bool takes_it_back = input.stops > 0 || input.toggle_control;
  if (!view.in_control) {
    return end_by_loss(now, view, input);
  }
  if (ends_by_landing(now, input)) {
    return true;
  }
  if (takes_it_back || now - since_ >= kHover) {
    give_back(now, takes_it_back, input);
  } else if (input.land && may_land()) {
    begin_task(now, protocol::Task::kLand);
  } else if (input.land) {
    report(now, kNoLanding);
  }
  return true;
}

}  // namespace m100::companion
