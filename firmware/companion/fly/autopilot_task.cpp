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
/// A touch-down shakes the estimate for less, and a wind needs as long for 0.1 m/s more.
constexpr core::Duration kFastFor = std::chrono::milliseconds(200);
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

std::optional<bool> is_on_ground(const link::SerialLink& link, core::TimePoint now) {
  const core::TimePoint came = link.received_at(protocol::TelemetryItem::kFlightStatus);
  const bool is_known = came != core::TimePoint{} && now - came <= kStatusTimeout;
  return is_known ? std::optional(is_on_ground(link.telemetry().flight_status)) : std::nullopt;
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
  if (is_flown() && drifts(now, controller)) {
    fail(Failure::kDrifted);
  }
  if (state_ == State::kWaiting) {
    send_request(now, controller);
  } else if (state_ == State::kRequested) {
    update_answer(now, controller);
  } else if (state_ == State::kActive) {
    update_status(now, controller.link());
  }
  if (is_flown() || state_ == State::kWaiting) {
    controller.task_flies(in_air(controller));
  } else if (failure_ == Failure::kDrifted || failure_ == Failure::kTimeout) {
    controller.end_task();
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
    requested_at_ = slow_since_ = now;
    from_w_m_.reset();
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
  const bool rises = is_flown() && controller.estimate().healthy && from_w_m_ &&
                     controller.estimate().height_m - ground_z_m_ > kRisen_m;
  return task_ == Task::kLand || rises;
}

/// False while no pose shows it, when the estimate began anew at another place, and after the task's end: then the
/// command of kLevel brakes.
bool AutopilotTask::drifts(core::TimePoint now, const Controller& controller) {
  const safety::Observation& seen = controller.observed();
  const est::Estimate<double>& at = controller.estimate();
  const core::Vector<double, 3> at_w_m{at.x.position_m, at.y.position_m, at.height_m};
  const bool is_known = seen.estimate.healthy && seen.consistency.refused_poses == 0;
  const bool is_slow = !is_known || seen.consistency.speed_m_s <= kMaxTouchDown_m_s;
  slow_since_ = is_slow ? now : slow_since_;
  if (!is_known || is_at_end(task_, status_)) {
    return false;
  }
  const std::uint32_t resets = controller.observer_counters().recoveries;
  if (!from_w_m_ || resets != resets_) {
    from_w_m_ = at_w_m;
    resets_ = resets;
    ground_z_m_ = task_ == Task::kTakeOff && state_ == State::kRequested ? at_w_m.z() : ground_z_m_;
  }
  if (task_ == Task::kLand) {
    return (at_w_m - *from_w_m_).head<2>().norm() > kMaxDrift_m || now - slow_since_ >= kFastFor;
  }
  const auto is_beside = [&](Eigen::Index axis) {
    const core::Fence::Side& side = fence_.side[static_cast<std::size_t>(axis)];
    return at_w_m[axis] < side.low_m || at_w_m[axis] > side.high_m;
  };
  return in_air(controller) && (is_beside(0) || is_beside(1));
}

/// How fast a level aircraft would be after sinking to the ground: the estimated disturbance accelerates it. The drag
/// of its own motion is left out; at 0.3 1/s it would take a third off in 3 s. Zero where the estimate does not know.
double AutopilotTask::touch_down_m_s(const Controller& controller) const {
  const est::Estimate<double>& at = controller.estimate();
  const double wind_m_s2 = std::hypot(at.x.disturbance_m_s2, at.y.disturbance_m_s2);
  const double sinks_for_s = std::max(0.0, at.height_m - ground_z_m_) / kSink_m_s;
  return at.healthy ? controller.observed().consistency.speed_m_s + wind_m_s2 * sinks_for_s : 0.0;
}

void AutopilotTask::fail(Failure failure) {
  state_ = State::kFailed;
  failure_ = failure;
}

std::string_view name(Task task) { return task == Task::kTakeOff ? "take-off" : "landing"; }

TextLine describe(const AutopilotTask& task) {
  constexpr std::array<std::string_view, 8> kWords{
      // in the order of Failure
      "",
      " refused by the autopilot: ",
      ": the autopilot does not answer, and its flight status does not show it",
      ": the request could not be sent",
      ": the autopilot accepted it but did not begin",
      ": the autopilot aborted it",
      ": the autopilot did not finish it in time",
      ": it drifts with the wind and was ended",
  };
  TextLine line;
  line.add(name(task.task())).add(kWords[static_cast<std::size_t>(task.failure())]);
  if (task.failure() == AutopilotTask::Failure::kRefused) {
    line.add(task.answer().name).add(", code ").add(static_cast<double>(task.answer().code), 0);
    line.add("; ").add(task.answer().remedy);
  }
  return line;
}

}  // namespace m100::companion
