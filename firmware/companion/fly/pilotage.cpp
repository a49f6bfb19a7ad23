// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/fly/pilotage.h"

#include "firmware/companion/fly/words.h"
#include "firmware/core/maths.h"

namespace m100::companion {
namespace {

using Excitation = ctl::Excitation<double>;

/// As long as an order to fly is valid in the flight controller: after a later grant nothing would fly.
constexpr core::Duration kPatience = std::chrono::seconds(20);

constexpr std::string_view kNoLanding = "landing is not ordered: the program does not fly the aircraft";

bool waits_for_the_operator(safety::Stage stage) {
  return stage == safety::Stage::kReady || stage == safety::Stage::kSilent || stage == safety::Stage::kSilentCold;
}

}  // namespace

bool Pilotage::tick(core::TimePoint now, const OperatorInput& input) {
  const View& view = controller_.link().authority();
  tell_stage(now, view);
  tell_ladder(now);
  tell_excitation(now);
  tell_swing(now);
  home_.watch(controller_, now);
  tell_home(now);
  back_.watch(now, view);
  led_ = input.led;
  if (input.land && (phase_ == Phase::kWaiting || phase_ == Phase::kAsking || phase_ == Phase::kHandingBack)) {
    tell(now, kNoLanding);
  }
  switch (phase_) {
    case Phase::kWaiting:
      return wait(now, view, input);
    case Phase::kAsking:
      return ask(now, view, input);
    case Phase::kTask:
      return fly_task(now, view, input);
    case Phase::kFlying:
      return fly(now, view, input);
    case Phase::kHandingBack:
      return hand_back(now, view, input);
  }
  return false;
}

bool Pilotage::wait(core::TimePoint now, const View& view, const OperatorInput& input) {
  if (input.stops > 0) {
    if (!view.owed) {
      return false;
    }
    begin_hand_back(now, false, input);
    return true;
  }
  // A take-off needs to know whether the aircraft is on the ground or in the air.
  const bool is_known = !wishes_.take_off || GroundView(controller_.link(), now).known;
  const bool all_ready =
      view.stage == safety::Stage::kReady && is_known && obstacle_now(takes_off_from_here(now)) == safety::Cause::kNone;
  // An operator who gives a command has looked at the aircraft; take_control acts in the first tick with all ready.
  if (wishes_.take_control && !order_given_ && all_ready && controller_.has_looked()) {
    order_given_ = true;
    try_to_engage(now, input.guarded);
  } else if (input.word) {
    try_to_engage(now, input.guarded);
  }
  tell_what_is_awaited(now, view);
  waits_since_ = all_ready || phase_ != Phase::kWaiting ? now : waits_since_.value_or(now);
  // Control was refused before it was requested, for a reason that does not go away by itself or has not gone away.
  const bool has_waited = wishes_.take_control && now - *waits_since_ > kPatience;
  const bool stuck =
      view.stage == safety::Stage::kSilent || view.stage == safety::Stage::kSilentCold || order_given_ || has_waited;
  const bool ends = wishes_.once && phase_ == Phase::kWaiting && stuck && !view.asked && !view.owed;
  if (ends && view.stage != safety::Stage::kReady && has_waited) {
    TextLine line;
    describe(line.add("control could not be asked for within 20 s: "), view);
    tell(now, line.text());
  }
  return !ends;
}

/// The position counts only if nothing else prevents flying by it. If goals have led, the next flight begins where the
/// aircraft is; a take-off begins where the aircraft stood.
bool Pilotage::is_out_of_reach(bool takes_off) const {
  const est::Estimate<double>& at = controller_.estimate();
  const core::Vector<double, 3>& from = takes_off ? wishes_.stands_w_m : wishes_.begins_w_m;
  const core::Vector<double, 3> away{at.x.position_m - from.x(), at.y.position_m - from.y(), at.height_m - from.z()};
  const bool is_known = is_outside(takes_off) || obstacle_now(takes_off) == safety::Cause::kNone;
  const bool is_bound = takes_off || !led_;
  return is_known && is_bound && away.squaredNorm() > wishes_.reach_m * wishes_.reach_m;
}

bool Pilotage::takes_off_from_here(core::TimePoint now) const {
  return wishes_.take_off && GroundView(controller_.link(), now).on_ground;
}

bool Pilotage::is_outside(bool takes_off) const { return obstacle_now(takes_off) == safety::Cause::kFenceLeft; }

/// Before the first telemetry package its age is meaningless, and the lost estimate would be blamed on the pose. The
/// floor of the fence does not prevent a take-off.
safety::Cause Pilotage::obstacle_now(bool takes_off) const {
  if (controller_.link().health().packages == 0) {
    return safety::Cause::kTelemetryOld;
  }
  const safety::Cause cause = obstacle(controller_.observed(), limits_);
  return takes_off && cause == safety::Cause::kFenceLeft ? safety::Cause::kNone : cause;
}

void Pilotage::try_to_engage(core::TimePoint now, bool guarded) {
  if (!guarded) {
    tell(now, "control is not asked for: nobody would give it back if this program died; end m100 and start it again");
    return;
  }
  if (wishes_.take_off && !GroundView(controller_.link(), now).known) {
    TextLine line;
    line.add(
        "control was not asked for: without the autopilot's flight status it is not known whether the aircraft is on ");
    tell(now, line.add("the ground; ").add(next_word(order_given_)).text());
    return;
  }
  takes_off_ = takes_off_from_here(now);
  const safety::Cause cause = obstacle_now(takes_off_);
  // Before telemetry there is no estimate: the order waits for start-up.
  if (cause == safety::Cause::kPoseRefused || cause == safety::Cause::kPoseOld) {
    tell_obstacle(now, cause);
    return;
  }
  if (is_elsewhere(takes_off_)) {
    tell_place(now, takes_off_);
    return;
  }
  controller_.engage();
  back_.note_ask(controller_.link().health().outages);
  had_control_ = false;
  landed_ = false;
  phase_ = Phase::kAsking;
  since_ = now;
}

bool Pilotage::is_refused(core::TimePoint now, const View& view) const {
  return now > since_ && !view.asked && waits_for_the_operator(view.stage);
}

bool Pilotage::ask(core::TimePoint now, const View& view, const OperatorInput& input) {
  const bool elsewhere = is_elsewhere(takes_off_);
  if (view.in_control && !elsewhere) {
    phase_ = Phase::kFlying;
    flew_ = true;
    had_control_ = true;
    engaged_ = false;
    since_ = now;
    if (takes_off_) {
      begin_task(now, protocol::Task::kTakeOff);
    }
    return true;
  }
  if (takes_off_) {
    controller_.task_flies(protocol::Task::kTakeOff);  // if control is granted in the next tick, the law must not fly
  }
  const bool takes_it_back = now > since_ && (input.stops > 0 || input.word);
  if (takes_it_back || elsewhere || !input.guarded || now - since_ > kPatience) {
    if (elsewhere) {
      tell_place(now, takes_off_);
    } else if (!takes_it_back && input.guarded) {
      tell(now, "control was not granted within 20 s");
    }
    controller_.release();  // a request may already be granted
    begin_hand_back(now, takes_it_back, input);
  } else if (is_refused(now, view)) {
    TextLine line;
    line.add("refused: ");
    describe(line, view);
    tell(now, line.add("; ").add(next_word(true)).text());
    begin_hand_back(now, false, input);
  }
  return true;
}

bool Pilotage::fly(core::TimePoint now, const View& view, const OperatorInput& input) {
  engaged_ = engaged_ || safety::passes_law(controller_.supervisor().rung());
  if (!view.in_control) {
    tell_end(now, view);
    begin_hand_back(now, false, input);
    return true;
  }
  if (!engaged_ && is_elsewhere(false)) {  // control was granted while the position was unknown
    tell_place(now, false);
    controller_.release();
    begin_hand_back(now, false, input);
    return true;
  }
  const Excitation::State excitation = controller_.excitation().state();
  if (excitation == Excitation::State::kReturning || excitation == Excitation::State::kMoving) {
    since_ = now;  // --hold counts from the end of the excitation
  }
  end_or_fly_on(now, input);
  return true;
}

void Pilotage::end_or_fly_on(core::TimePoint now, const OperatorInput& input) {
  const bool at_home = home_.state() == Homeward<double>::State::kThere;
  const bool is_held = wishes_.take_control && core::seconds<double>(now - since_) >= wishes_.hold_s;
  const bool is_over = at_home || (is_held && !goes_home());
  const bool ends = is_over && !(wishes_.land && may_land());
  if (input.stops > 0 || input.word || ends) {
    controller_.release();
    begin_hand_back(now, !at_home, input);
  } else if (may_land() && (input.land || is_over)) {
    begin_task(now, protocol::Task::kLand);
  } else if (input.land) {
    tell(now, kNoLanding);
  }
}

bool Pilotage::may_land() const {
  const safety::Rung rung = controller_.supervisor().rung();
  const bool is_ours = phase_ == Phase::kFlying || phase_ == Phase::kTask;
  return is_ours && rung != safety::Rung::kRelease && rung != safety::Rung::kSilent;
}

void Pilotage::begin_hand_back(core::TimePoint now, bool by_operator, const OperatorInput& input) {
  phase_ = Phase::kHandingBack;
  since_ = now;
  back_.begin(now, input.stops);
  by_operator_ = by_operator;
  given_back_ = false;
  ends_ = by_operator || wishes_.once || input.stops > 0;
}

bool Pilotage::hand_back(core::TimePoint now, const View& view, const OperatorInput& input) {
  ends_ = ends_ || input.stops > 0;
  if (now > since_ && view.in_control && controller_.supervisor().rung() == safety::Rung::kSilent) {
    controller_.release();  // again: a delayed answer may have granted control meanwhile
  }
  switch (back_.look(now, controller_.link(), input.stops)) {
    case HandBack::State::kGoesOn:
      return true;
    case HandBack::State::kGivesUp:
      return !ends_;
    case HandBack::State::kOver:
      break;
  }
  given_back_ = by_operator_ && had_control_ && back_.is_with_the_pilot();
  phase_ = Phase::kWaiting;
  clear_ = now;
  return !ends_;
}

}  // namespace m100::companion
