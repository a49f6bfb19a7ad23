// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/fly/pilotage.h"

#include "firmware/companion/fly/words.h"
#include "firmware/core/maths.h"

namespace m100::companion {
namespace {

using Excitation = ctl::Excitation<double>;

/// Longer than this, and the operator reads what the pilot has to do (promise R15).
constexpr core::Duration kHandBack = std::chrono::seconds(1);
/// A port that is gone for longer does not come back in this flight: where the program was to end, it ends.
constexpr core::Duration kPortReturns = std::chrono::seconds(5);
/// As long as an order to fly lasts in the flight controller: a later grant would fly nothing.
constexpr core::Duration kPatience = std::chrono::seconds(20);

constexpr std::string_view kAgain = "Enter (or SIGUSR1) asks for control again, Ctrl-C ends the program";
constexpr std::string_view kPilotsPart = "PILOT: turn the mode switch to P and back to F";

bool waits_for_the_operator(safety::Stage stage) {
  return stage == safety::Stage::kReady || stage == safety::Stage::kSilent || stage == safety::Stage::kSilentCold;
}

}  // namespace

bool Pilotage::tick(core::TimePoint now, const OperatorInput& input) {
  const View& view = controller_.link().authority();
  port_here_ = view.port_gone ? port_here_ : now;
  tell_stage(now, view);
  tell_ladder(now);
  tell_excitation(now);
  tell_trouble(now, view);
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
  const bool all_ready =
      view.stage == safety::Stage::kReady && obstacle(controller_.observed(), limits_) == safety::Cause::kNone;
  if (wishes_.take_control && !order_given_ && all_ready) {
    order_given_ = true;
    try_to_engage(now);
  } else if (input.word) {
    try_to_engage(now);
  }
  // Refused before anybody could ask, for a reason that does not heal by itself.
  const bool stuck = view.stage == safety::Stage::kSilent || view.stage == safety::Stage::kSilentCold || order_given_;
  return !(wishes_.once && phase_ == Phase::kWaiting && stuck && !view.asked && !view.owed);
}

/// What is known of the place counts only while nothing stands against flying by it.
bool Pilotage::is_out_of_reach() const {
  const est::Estimate<double>& at = controller_.estimate();
  const core::Vector<double, 3> away{at.x.position_m - wishes_.begins_w_m.x(), at.y.position_m - wishes_.begins_w_m.y(),
                                     at.height_m - wishes_.begins_w_m.z()};
  return obstacle(controller_.observed(), limits_) == safety::Cause::kNone &&
         away.squaredNorm() > wishes_.reach_m * wishes_.reach_m;
}

void Pilotage::tell_reach(core::TimePoint now) {
  const est::Estimate<double>& at = controller_.estimate();
  TextLine line;
  line.add("control is not taken: the aircraft is at ").add(at.x.position_m, 1).add(", ").add(at.y.position_m, 1);
  line.add(", ").add(at.height_m, 1).add(" m, and the course begins at ").add(wishes_.begins_w_m.x(), 1).add(", ");
  line.add(wishes_.begins_w_m.y(), 1).add(", ").add(wishes_.begins_w_m.z(), 1);
  tell(now, line.add(" m: fly there, or start m100 again here; ").add(kAgain).text());
}

void Pilotage::try_to_engage(core::TimePoint now) {
  const safety::Cause cause = obstacle(controller_.observed(), limits_);
  // Before telemetry there is no estimate: the order waits for start-up.
  if (cause == safety::Cause::kPoseRefused || cause == safety::Cause::kPoseOld) {
    TextLine line;
    line.add("control was not asked for; ");
    describe(line, cause, controller_.observed(), limits_);
    tell(now, line.add(": see to the source of pose; ").add(kAgain).text());
    return;
  }
  if (is_out_of_reach()) {
    tell_reach(now);
    return;
  }
  controller_.engage();
  outages_before_ = controller_.link().health().outages;
  phase_ = Phase::kAsking;
  since_ = now;
}

bool Pilotage::is_refused(core::TimePoint now, const View& view) const {
  return now > since_ && !view.asked && waits_for_the_operator(view.stage);
}

bool Pilotage::ask(core::TimePoint now, const View& view, const OperatorInput& input) {
  if (view.in_control) {
    phase_ = Phase::kFlying;
    flew_ = true;
    engaged_ = false;
    since_ = now;
    return true;
  }
  const bool takes_it_back = now > since_ && (input.stops > 0 || input.word);
  const bool too_far = is_out_of_reach();
  if (takes_it_back || too_far || now - since_ > kPatience) {
    if (too_far) {
      tell_reach(now);
    } else if (!takes_it_back) {
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
    describe(line, obstacle(controller_.observed(), limits_), controller_.observed(), limits_);
  }
  tell(now, line.add("; ").add(kAgain).text());
}

void Pilotage::begin_hand_back(core::TimePoint now, bool by_operator, const OperatorInput& input) {
  phase_ = Phase::kHandingBack;
  since_ = now;
  by_operator_ = by_operator;
  given_back_ = false;
  stops_before_ = input.stops;
  ends_ = by_operator || wishes_.once || input.stops > 0;
}

bool Pilotage::hand_back(core::TimePoint now, const View& view, const OperatorInput& input) {
  ends_ = ends_ || input.stops > 0;
  if (now > since_ && view.in_control && controller_.supervisor().rung() == safety::Rung::kSilent) {
    controller_.release();  // once more: an answer that was on its way may have granted control meanwhile
  }
  if (now > since_ && !view.owed && !view.in_control && view.stage != safety::Stage::kReleasing) {
    given_back_ = by_operator_ && view.heard;
    const bool is_certain = controller_.link().health().outages == outages_before_;
    tell(now, !view.heard ? "control was never ours, and nothing comes from the autopilot"
              : is_certain
                  ? "the transmitter has the aircraft"
                  : "telemetry at the port shows that the transmitter has control. The port was gone: if another "
                    "autopilot was plugged in, this says nothing of the one that flew");
    phase_ = Phase::kWaiting;
    return !ends_;
  }
  // Ending without knowing: only where nothing of ours can arrive any more, or where the operator insists.
  const bool insists = input.stops > stops_before_ + (stops_before_ == 0 ? 1U : 0U);
  const bool gives_up = view.port_gone && now - port_here_ > kPortReturns;
  return !(ends_ && (gives_up || (insists && now - since_ > kHandBack)));
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

void Pilotage::tell_trouble(core::TimePoint now, const View& view) {
  Trouble trouble = Trouble::kNone;
  if (view.owed && view.port_gone) {
    trouble = Trouble::kPortGone;
  } else if (view.owed && !view.heard && !view.in_control) {
    trouble = Trouble::kNothingHeard;
  } else if (view.owed && view.reason == safety::Reason::kUnheard) {
    trouble = Trouble::kUnheard;
  } else if (view.owed && phase_ == Phase::kHandingBack && now - since_ > kHandBack) {
    trouble = Trouble::kStillOurs;
  }
  if (trouble != told_trouble_ && trouble != Trouble::kNone) {
    TextLine line;
    line.add(trouble == Trouble::kPortGone       ? "the port is gone: no byte of ours reaches the autopilot. "
             : trouble == Trouble::kNothingHeard ? "nothing comes from the autopilot; control is given back blind. "
             : trouble == Trouble::kUnheard      ? "the autopilot answers nothing: no byte of ours reaches it. "
                                                 : "the autopilot does not show that the transmitter has control. ");
    tell(now, line.add(kPilotsPart).add(". The program goes on giving back").text());
  }
  told_trouble_ = trouble;
}

}  // namespace m100::companion
