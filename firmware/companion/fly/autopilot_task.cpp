// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/fly/autopilot_task.h"

#include <algorithm>
#include <cmath>

namespace m100::companion {
namespace {

using protocol::FlightStatus;
using protocol::Task;

constexpr core::Duration kAckTimeout = std::chrono::seconds(1);
constexpr core::Duration kStartTimeout = std::chrono::seconds(5);
constexpr core::Duration kAirborneTime = std::chrono::milliseconds(500);  ///< in the air for so long: taken off
constexpr core::Duration kAbortTime = std::chrono::seconds(1);
constexpr core::Duration kTakeOffTimeout = std::chrono::seconds(20);
constexpr core::Duration kLandingTimeout = std::chrono::seconds(90);
constexpr double kRisen_m = 0.3;  ///< higher than noise of the height: the aircraft is in the air
/// In a landing, from where it was requested. A wind that the estimate did not show has carried it away.
constexpr double kMaxDrift_m = 1.0;
/// Sideways, in a landing: an aircraft that touches down faster may fall over.
constexpr double kMaxTouchDown_m_s = 0.5;
constexpr double kSink_m_s = 0.4;                                   ///< of the autopilot's landing, at least [inferred]
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
    case State::kWouldDrift:
    case State::kFailed:
      break;
  }
  const bool is_flown = state_ == State::kRequested || state_ == State::kActive;
  if (is_flown && drifts(controller)) {
    fail(Failure::kDrifted);
    controller.end_task();
  } else if (is_flown || state_ == State::kWaiting) {
    controller.task_flies(in_air(controller));
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
  if (may_request(now, controller) && task_ == Task::kLand && touch_down_m_s(controller) > kMaxTouchDown_m_s) {
    state_ = State::kWouldDrift;
  } else if (may_request(now, controller) && controller.begin_task(task_) == core::Status::kOk) {
    const est::Estimate<double>& at = controller.estimate();
    requested_at_ = now;
    requested_from_m_ = {at.x.position_m, at.y.position_m, at.height_m};
    ground_m_ = task_ == Task::kTakeOff ? at.height_m : ground_m_;
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

bool AutopilotTask::in_air(const Controller& controller) const {
  const bool is_flown = state_ == State::kRequested || state_ == State::kActive;
  const bool rises =
      is_flown && controller.estimate().healthy && controller.estimate().height_m - requested_from_m_.z() > kRisen_m;
  return task_ == Task::kLand || rises;
}

/// False while no pose shows it, and after the task's end: then the command of kLevel brakes.
bool AutopilotTask::drifts(const Controller& controller) const {
  const safety::Observation& seen = controller.observed();
  const core::Vector<double, 2> at_m{controller.estimate().x.position_m, controller.estimate().y.position_m};
  const auto is_beside = [&](int axis) {
    const core::Fence::Side& side = fence_.side[static_cast<std::size_t>(axis)];
    return at_m[axis] < side.low_m || at_m[axis] > side.high_m;
  };
  const bool leaves = task_ == Task::kTakeOff ? in_air(controller) && (is_beside(0) || is_beside(1))
                                              : (at_m - requested_from_m_.head<2>()).norm() > kMaxDrift_m ||
                                                    seen.consistency.speed_m_s > kMaxTouchDown_m_s;
  return leaves && !is_at_end(task_, status_) && seen.estimate.healthy && seen.consistency.refused_poses == 0;
}

/// How fast a level aircraft would be after sinking to the ground: the estimated disturbance accelerates it. The drag
/// of its own motion is left out; at 0.3 1/s it would take a third off in 3 s. Zero where the estimate does not know.
double AutopilotTask::touch_down_m_s(const Controller& controller) const {
  const est::Estimate<double>& at = controller.estimate();
  const double blows_m_s2 = std::hypot(at.x.disturbance_m_s2, at.y.disturbance_m_s2);
  return at.healthy ? blows_m_s2 * std::max(0.0, at.height_m - ground_m_) / kSink_m_s : 0.0;
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
    case AutopilotTask::Failure::kDrifted:
      line.add(": it drifts with the wind and was ended");
      return;
    case AutopilotTask::Failure::kNone:
      return;
  }
}

}  // namespace m100::companion
