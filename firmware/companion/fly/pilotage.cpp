// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/fly/pilotage.h"

#include "firmware/companion/fly/words.h"
#include "firmware/core/maths.h"

namespace m100::companion {
namespace {

using Excitation = ctl::Excitation<double>;

/// What stands in the way of a flight for longer is said.
constexpr core::Duration kObstacleTold = std::chrono::seconds(1);
/// As long as an order to fly lasts in the flight controller: a later grant would fly nothing.
constexpr core::Duration kPatience = std::chrono::seconds(20);

constexpr std::string_view kAgain = "Enter (or SIGUSR1) asks for control again, Ctrl-C ends the program";

bool waits_for_the_operator(safety::Stage stage) {
  return stage == safety::Stage::kReady || stage == safety::Stage::kSilent || stage == safety::Stage::kSilentCold;
}

}  // namespace

bool Pilotage::tick(core::TimePoint now, const OperatorInput& input) {
  const View& view = controller_.link().authority();
  tell_stage(now, view);
  tell_ladder(now);
  tell_excitation(now);
  back_.watch(now, view);
  led_ = input.led;
  switch (phase_) {
    case Phase::kWaiting:
      return wait(now, view, input);
    case Phase::kAsking:
      return ask(now, view, input);
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
  const bool all_ready = view.stage == safety::Stage::kReady && obstacle_now() == safety::Cause::kNone;
  if (wishes_.take_control && !order_given_ && all_ready) {
    order_given_ = true;
    try_to_engage(now, input.guarded);
  } else if (input.word) {
    try_to_engage(now, input.guarded);
  }
  tell_what_is_awaited(now, view);
  waits_since_ = all_ready || phase_ != Phase::kWaiting ? now : waits_since_.value_or(now);
  // Refused before anybody could ask, for a reason that does not heal by itself, or that has not healed.
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

/// Telemetry is there and the pose is not: without a word the operator would wait for nothing.
void Pilotage::tell_what_is_awaited(core::TimePoint now, const View& view) {
  const safety::Cause cause = view.stage == safety::Stage::kReady ? obstacle_now() : safety::Cause::kNone;
  if (cause == safety::Cause::kNone || phase_ != Phase::kWaiting) {
    clear_ = now;
    told_obstacle_ = safety::Cause::kNone;
    return;
  }
  if (now - clear_ > kObstacleTold && told_obstacle_ == safety::Cause::kNone) {
    told_obstacle_ = cause;
    TextLine line;
    line.add("control is not asked for yet; ");
    describe(line, cause, controller_.observed(), limits_);
    tell(now, line.add(": ").add(what_helps(cause)).text());
  }
}

/// Before the first package of telemetry its age says nothing, and the estimate's age would be the pose's.
safety::Cause Pilotage::obstacle_now() const {
  const bool has_telemetry = controller_.link().health().packages > 0;
  return has_telemetry ? obstacle(controller_.observed(), limits_) : safety::Cause::kTelemetryOld;
}

bool Pilotage::is_outside() const { return obstacle_now() == safety::Cause::kFenceLeft; }

/// What is known of the place counts only while nothing but the place stands against flying by it.
bool Pilotage::is_out_of_reach() const {
  const est::Estimate<double>& at = controller_.estimate();
  const core::Vector<double, 3> away{at.x.position_m - wishes_.begins_w_m.x(), at.y.position_m - wishes_.begins_w_m.y(),
                                     at.height_m - wishes_.begins_w_m.z()};
  const bool is_known = is_outside() || obstacle_now() == safety::Cause::kNone;
  return is_known && !led_ && away.squaredNorm() > wishes_.reach_m * wishes_.reach_m;
}

void Pilotage::tell_place(core::TimePoint now) {
  if (is_outside()) {
    tell_obstacle(now, safety::Cause::kFenceLeft);
  } else {
    tell_reach(now);
  }
}

void Pilotage::tell_obstacle(core::TimePoint now, safety::Cause cause) {
  TextLine line;
  line.add("control is not taken; ");
  describe(line, cause, controller_.observed(), limits_);
  tell(now, line.add(": ").add(what_helps(cause)).add("; ").add(kAgain).text());
}

void Pilotage::tell_reach(core::TimePoint now) {
  const est::Estimate<double>& at = controller_.estimate();
  TextLine line;
  line.add("control is not taken: the aircraft is at ").add(at.x.position_m, 1).add(", ").add(at.y.position_m, 1);
  line.add(", ").add(at.height_m, 1).add(" m, and the course begins at ").add(wishes_.begins_w_m.x(), 1).add(", ");
  line.add(wishes_.begins_w_m.y(), 1).add(", ").add(wishes_.begins_w_m.z(), 1);
  tell(now, line.add(" m: fly there, or start m100 again here; ").add(kAgain).text());
}

void Pilotage::try_to_engage(core::TimePoint now, bool guarded) {
  if (!guarded) {
    tell(now, "control is not asked for: nobody would give it back if this program died; end it and start it again");
    return;
  }
  const safety::Cause cause = obstacle_now();
  // Before telemetry there is no estimate: the order waits for start-up.
  if (cause == safety::Cause::kPoseRefused || cause == safety::Cause::kPoseOld) {
    tell_obstacle(now, cause);
    return;
  }
  if (is_elsewhere()) {
    tell_place(now);
    return;
  }
  controller_.engage();
  back_.note_ask(controller_.link().health().outages);
  had_control_ = false;
  phase_ = Phase::kAsking;
  since_ = now;
}

bool Pilotage::is_refused(core::TimePoint now, const View& view) const {
  return now > since_ && !view.asked && waits_for_the_operator(view.stage);
}

bool Pilotage::ask(core::TimePoint now, const View& view, const OperatorInput& input) {
  const bool elsewhere = is_elsewhere();
  if (view.in_control && !elsewhere) {
    phase_ = Phase::kFlying;
    flew_ = true;
    had_control_ = true;
    engaged_ = false;
    since_ = now;
    return true;
  }
  const bool takes_it_back = now > since_ && (input.stops > 0 || input.word);
  if (takes_it_back || elsewhere || !input.guarded || now - since_ > kPatience) {
    if (elsewhere) {
      tell_place(now);
    } else if (!takes_it_back && input.guarded) {
      tell(now, "control was not granted within 20 s");
    }
    controller_.release();  // what is only asked for may already be granted
    begin_hand_back(now, takes_it_back, input);
  } else if (is_refused(now, view)) {
    TextLine line;
    line.add("refused: ");
    describe(line, view);
    tell(now, line.add("; ").add(kAgain).text());
    begin_hand_back(now, false, input);
  }
  return true;
}

bool Pilotage::fly(core::TimePoint now, const View& view, const OperatorInput& input) {
  engaged_ = engaged_ || controller_.supervisor().rung() != safety::Rung::kSilent;
  if (!view.in_control) {
    tell_end(now, view);
    begin_hand_back(now, false, input);
    return true;
  }
  if (!engaged_ && is_elsewhere()) {  // granted while no place was known
    tell_place(now);
    controller_.release();
    begin_hand_back(now, false, input);
    return true;
  }
  const Excitation::State excitation = controller_.excitation().state();
  if (excitation == Excitation::State::kReturning || excitation == Excitation::State::kMoving) {
    since_ = now;  // what was wished to be held counts from its end
  }
  const bool is_over = wishes_.take_control && core::seconds<double>(now - since_) >= wishes_.hold_s;
  if (input.stops > 0 || input.word || is_over) {
    controller_.release();
    begin_hand_back(now, true, input);
  }
  return true;
}

void Pilotage::tell_end(core::TimePoint now, const View& view) {
  TextLine line;
  line.add("the flight has ended: ");
  if (view.stage != safety::Stage::kReleasing && view.reason != safety::Reason::kReleased) {
    describe(line, view);
  } else if (engaged_) {
    const safety::LadderStep& step = controller_.supervisor().descent();
    describe(line, step.cause, step.seen, limits_);
    line.add("; control goes back to the transmitter");
  } else {
    line.add("control was not used; ");
    describe(line, obstacle_now(), controller_.observed(), limits_);
  }
  tell(now, line.add("; ").add(kAgain).text());
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
    controller_.release();  // once more: an answer that was on its way may have granted control meanwhile
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

void Pilotage::tell_stage(core::TimePoint now, const View& view) {
  if (told_stage_ && view.stage == last_stage_ && view.reason == last_reason_) {
    return;
  }
  told_stage_ = true;
  last_stage_ = view.stage;
  last_reason_ = view.reason;
  TextLine line;
  describe(line, view);
  tell(now, line.text());
}

void Pilotage::tell_ladder(core::TimePoint now) {
  const std::uint32_t made = controller_.supervisor().stats().steps;
  if (made == told_steps_) {
    return;
  }
  told_steps_ = made;
  const safety::LadderStep& step = controller_.supervisor().last_step();
  if (step_count_ < steps_.size()) {
    steps_[step_count_++] = step;
  }
  TextLine line;
  line.add("ladder: ").add(safety::name(step.from)).add(" to ").add(safety::name(step.to)).add(", ");
  line.add(safety::name(step.cause)).add(": ");
  describe(line, step.cause, step.seen, limits_);
  tell(now, line.text());
}

void Pilotage::tell_excitation(core::TimePoint now) {
  const Excitation& excitation = controller_.excitation();
  if (excitation.state() == told_excitation_) {
    return;
  }
  told_excitation_ = excitation.state();
  TextLine line;
  describe(line, excitation);
  if (!line.text().empty()) {
    tell(now, line.text());
  }
}

}  // namespace m100::companion
