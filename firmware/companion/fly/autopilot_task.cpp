// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/fly/autopilot_task.h"

namespace m100::companion {
namespace {

using protocol::FlightStatus;
using protocol::Task;

constexpr core::Duration kStatusTimeout = std::chrono::seconds(2);  ///< the item comes ten times a second

/// A take-off begins on the ground and ends in the air, a landing the other way round.
bool is_at_end(Task task, FlightStatus status) {
  return task == Task::kTakeOff ? status == FlightStatus::kInAir : is_on_ground(status);
}
bool is_at_beginning(Task task, FlightStatus status) {
  return task == Task::kTakeOff ? is_on_ground(status) : status == FlightStatus::kInAir;
}

}  // namespace

LandedState::LandedState(const link::SerialLink& link, core::TimePoint now) {
  const core::TimePoint came = link.received_at(protocol::TelemetryItem::kFlightStatus);
  known = came != core::TimePoint{} && now - came <= kStatusTimeout;
  on_ground = known && is_on_ground(link.telemetry().flight_status);
}

void AutopilotTask::start(Task task, core::TimePoint now) {
  task_ = task;
  state_ = State::kWaiting;
  failure_ = Failure::kNone;
  answer_ = {};
  started_at_ = now;
  begun_ = false;
}

AutopilotTask::State AutopilotTask::tick(core::TimePoint now, Controller& controller) {
  switch (state_) {
    case State::kWaiting:
      send_request(now, controller);
      break;
    case State::kRequested:
      update_answer(now, controller);
      break;
    case State::kActive:
      update_status(now, controller.link());
      break;
    case State::kNone:
    case State::kDone:
    case State::kFailed:
      break;
  }
  if (state_ == State::kWaiting || state_ == State::kRequested || state_ == State::kActive) {
    controller.task_flies(task_);
  }
  return state_;
}

bool AutopilotTask::may_request(core::TimePoint now, const Controller& controller) const {
  const bool is_slow =
      controller.observed().consistency.speed_m_s < kMaxLandingSpeed_m_s || now - started_at_ >= kSlowDownTimeout;
  return controller.supervisor().failsafe_state() == safety::FailsafeState::kLevel &&
         now - requested_at_ >= kRequestInterval && (task_ == Task::kTakeOff || is_slow);
}

void AutopilotTask::send_request(core::TimePoint now, Controller& controller) {
  if (may_request(now, controller) && controller.begin_task(task_) == core::Status::kOk) {
    requested_at_ = now;
    status_ = controller.link().telemetry().flight_status;
    same_since_ = now;
    state_ = State::kRequested;
  } else if (now - started_at_ > kSlowDownTimeout + kRequestInterval) {
    fail(Failure::kNotSent);
  }
}

void AutopilotTask::update_answer(core::TimePoint now, const Controller& controller) {
  if (controller.link().task_is_open()) {
    return;
  }
  const protocol::AckMeaning& answer = controller.link().authority().answer;
  const FlightStatus shown = controller.link().telemetry().flight_status;
  const bool shows_it = shown == (task_ == Task::kTakeOff ? FlightStatus::kTakingOff : FlightStatus::kLanding);
  if (!answer.name.empty() && answer.verdict != protocol::AckVerdict::kDone) {
    answer_ = answer;
    fail(Failure::kRefused);
  } else if (!answer.name.empty() || shows_it) {  // an answer may be lost, and telemetry shows it, too
    state_ = State::kActive;
  } else if (now - requested_at_ > kAckTimeout) {
    fail(Failure::kNoAnswer);
  }
}

void AutopilotTask::update_status(core::TimePoint now, const link::SerialLink& link) {
  const FlightStatus shown = link.telemetry().flight_status;
  same_since_ = shown == status_ ? same_since_ : now;
  status_ = shown;
  const core::Duration same_for = now - same_since_;
  const bool takes_off = task_ == Task::kTakeOff;
  begun_ = begun_ || shown == (takes_off ? FlightStatus::kTakingOff : FlightStatus::kLanding);
  const bool is_new = begun_ || now - requested_at_ > kAckTimeout;  // the status no longer dates from before the task
  if (is_at_end(task_, shown) && (takes_off ? same_for >= kAirborneTime : is_new)) {
    state_ = State::kDone;
  } else if (!begun_ && now - requested_at_ > kStartTimeout) {
    fail(Failure::kNotStarted);
  } else if (begun_ && is_at_beginning(task_, shown) && same_for > kAbortTime) {
    fail(Failure::kAborted);
  } else if (now - requested_at_ > (takes_off ? kTakeOffTimeout : kLandingTimeout)) {
    fail(Failure::kTimeout);
  }
}

void AutopilotTask::fail(Failure failure) {
  state_ = State::kFailed;
  failure_ = failure;
}

std::string_view name(Task task) { return task == Task::kTakeOff ? "take-off" : "landing"; }

void describe(TextLine& line, const AutopilotTask& task) {
  line.add(name(task.task()));
  switch (task.failure()) {
    case AutopilotTask::Failure::kRefused:
      line.add(" refused by the autopilot: ").add(task.answer().name).add(", code ");
      line.add(static_cast<double>(task.answer().code), 0).add("; ").add(task.answer().remedy);
      return;
    case AutopilotTask::Failure::kNoAnswer:
      line.add(": the autopilot does not answer, and its flight status does not show it");
      return;
    case AutopilotTask::Failure::kNotSent:
      line.add(": the request could not be sent");
      return;
    case AutopilotTask::Failure::kNotStarted:
      line.add(": the autopilot accepted it but did not begin");
      return;
    case AutopilotTask::Failure::kAborted:
      line.add(": the autopilot aborted it");
      return;
    case AutopilotTask::Failure::kTimeout:
      line.add(": the autopilot did not finish it in time");
      return;
    case AutopilotTask::Failure::kNone:
      return;
  }
}

}  // namespace m100::companion
