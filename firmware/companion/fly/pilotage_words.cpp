// SPDX-License-Identifier: BSD-3-Clause
// The messages of a flight for the operator.
#include "firmware/companion/fly/pilotage.h"
#include "firmware/companion/fly/words.h"

namespace m100::companion {
namespace {

using Excitation = ctl::Excitation<double>;

/// An obstacle that lasts longer is reported.
constexpr core::Duration kObstacleTold = std::chrono::seconds(1);

}  // namespace

/// Reports an obstacle, such as a missing pose: otherwise the operator would wait without knowing why.
void Pilotage::tell_what_is_awaited(core::TimePoint now, const View& view) {
  const safety::Cause cause =
      view.stage == safety::Stage::kReady ? obstacle_now(takes_off_from_here(now)) : safety::Cause::kNone;
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

void Pilotage::tell_place(core::TimePoint now, bool takes_off) {
  if (is_outside(takes_off)) {
    tell_obstacle(now, safety::Cause::kFenceLeft);
  } else {
    tell_reach(now, takes_off);
  }
}

void Pilotage::tell_obstacle(core::TimePoint now, safety::Cause cause) {
  TextLine line;
  line.add("control is not taken; ");
  describe(line, cause, controller_.observed(), limits_);
  tell(now, line.add(": ").add(what_helps(cause)).add("; ").add(next_word(order_given_)).text());
}

void Pilotage::tell_reach(core::TimePoint now, bool takes_off) {
  const est::Estimate<double>& at = controller_.estimate();
  const core::Vector<double, 3>& from = takes_off ? wishes_.stands_w_m : wishes_.begins_w_m;
  TextLine line;
  line.add("control is not taken: the aircraft is at ").add(at.x.position_m, 1).add(", ").add(at.y.position_m, 1);
  line.add(", ")
      .add(at.height_m, 1)
      .add(takes_off ? " m, and the take-off begins at " : " m, and the course begins at ")
      .add(from.x(), 1)
      .add(", ");
  line.add(from.y(), 1).add(", ").add(from.z(), 1);
  tell(now, line.add(" m: fly there, or start m100 again here; ").add(next_word(order_given_)).text());
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
    line.add(takes_off_ ? "the law has not flown; " : "control was not used; ");
    describe(line, obstacle_now(takes_off_), controller_.observed(), limits_);
  }
  tell(now, line.add("; ").add(next_word(true)).text());
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

void Pilotage::tell_swing(core::TimePoint now) {
  const safety::Observation& seen = controller_.observed();
  if (seen.swings && !told_swing_) {
    swing_ = swing_ ? swing_ : seen;
    TextLine line;
    describe_swing(line, seen);
    tell(now, line.text());
  }
  told_swing_ = seen.swings;
}

void Pilotage::tell_home(core::TimePoint now) {
  using State = Homeward<double>::State;
  const State state = home_.state();
  if (state != told_home_ && state != State::kNotYet) {
    TextLine line;
    line.add("battery low: ").add(static_cast<double>(controller_.link().telemetry().battery_percent), 0);
    line.add(" %, the limit is ").add(home_.low_percent(), 0).add(" %; ");
    line.add(state == State::kFlies ? "the aircraft flies to where the flight began"
                                    : "the aircraft is where the flight began");
    tell(now, line.add(state == State::kFlies ? ", then the flight ends"
                       : wishes_.land         ? ", and lands"
                                              : "; control goes back to the transmitter: land")
                  .text());
  }
  told_home_ = state;
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
