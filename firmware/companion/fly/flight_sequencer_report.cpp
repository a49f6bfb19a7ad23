// SPDX-License-Identifier: BSD-3-Clause
// The messages of a flight for the operator.
#include "firmware/companion/fly/flight_sequencer.h"
#include "firmware/companion/operator/operator_messages.h"

#include <algorithm>

namespace m100::companion {
namespace {

using Excitation = ctl::Excitation<double>;

/// An obstacle that lasts longer is reported.
constexpr core::Duration kObstacleTold = std::chrono::seconds(1);

}  // namespace

/// Reports an obstacle, such as a missing pose: otherwise the operator would wait without knowing why.
void FlightSequencer::report_awaited(core::TimePoint now, const View& view) {
  const safety::FailsafeReason cause =
      view.stage == safety::AuthorityStage::kReady ? denial_now(starts_on_ground(now)) : safety::FailsafeReason::kNone;
  if (cause == safety::FailsafeReason::kNone || phase_ != Phase::kWaiting) {
    clear_ = now;
    reported_denial_ = safety::FailsafeReason::kNone;
    return;
  }
  if (now - clear_ > kObstacleTold && reported_denial_ == safety::FailsafeReason::kNone) {
    reported_denial_ = cause;
    TextLine line;
    line.add("control is not asked for yet; ");
    describe(line, cause, controller_.observed(), limits_);
    add_refused_poses(line, cause, now);
    report(now, line.add(": ").add(remedy_for(cause)).text());
  }
}

/// An old pose may be one of many that came and were refused.
void FlightSequencer::add_refused_poses(TextLine& line, safety::FailsafeReason cause, core::TimePoint now) const {
  const link::PoseLinkStats& poses = controller_.pose_link().stats();
  const bool is_lately = poses.last_fault != link::PoseFault::kNone && now - poses.last_fault_at < kObstacleTold;
  if (is_lately && (cause == safety::FailsafeReason::kPoseOld || cause == safety::FailsafeReason::kEstimateLost)) {
    line.add("; poses come and are refused: ").add(link::text_of(poses.last_fault).sentence);
  }
}

void FlightSequencer::report_position(core::TimePoint now, bool takes_off) {
  if (is_outside(takes_off)) {
    report_denial(now, safety::FailsafeReason::kFenceLeft);
  } else {
    report_distance(now, takes_off);
  }
}

void FlightSequencer::report_denial(core::TimePoint now, safety::FailsafeReason cause) {
  TextLine line;
  line.add("control is not taken; ");
  describe(line, cause, controller_.observed(), limits_);
  add_refused_poses(line, cause, now);
  report(now, line.add(": ").add(remedy_for(cause)).add("; ").add(next_input(order_given_)).text());
}

void FlightSequencer::report_distance(core::TimePoint now, bool takes_off) {
  const est::Estimate<double>& at = controller_.estimate();
  const core::Vector<double, 3>& from = takes_off ? request_.takeoff_position_w_m : request_.course_start_w_m;
  TextLine line;
  line.add("control is not taken: the aircraft is at ").add(at.x.position_m, 1).add(", ").add(at.y.position_m, 1);
  line.add(", ")
      .add(at.height_m, 1)
      .add(takes_off ? " m, and the take-off begins at " : " m, and the course begins at ")
      .add(from.x(), 1)
      .add(", ");
  line.add(from.y(), 1).add(", ").add(from.z(), 1);
  report(now, line.add(" m: fly there, or start m100 again here; ").add(next_input(order_given_)).text());
}

void FlightSequencer::report_end(core::TimePoint now, const View& view) {
  TextLine line;
  line.add("the flight has ended: ");
  if (view.stage != safety::AuthorityStage::kReleasing && view.reason != safety::AuthorityReason::kReleased) {
    describe(line, view);
  } else if (engaged_) {
    const safety::FailsafeStep& step = controller_.supervisor().descent();
    safety::Observation seen = step.seen;  // with the values at the end, not at the first crossing
    seen.pose_age = std::max(seen.pose_age, worst_.pose_age);
    seen.telemetry_age = std::max(seen.telemetry_age, worst_.telemetry_age);
    seen.outside_m = std::max(seen.outside_m, worst_.outside_m);
    seen.refused_by_m = std::max(seen.refused_by_m, worst_.refused_by_m);
    seen.authority_exceeded_for = std::max(seen.authority_exceeded_for, worst_.authority_exceeded_for);
    describe(line, step.reason, seen, limits_);
    line.add("; control goes back to the transmitter");
  } else {
    line.add(takes_off_ ? "the law has not flown; " : "control was not used; ");
    describe(line, denial_now(takes_off_), controller_.observed(), limits_);
  }
  report(now, line.add("; ").add(next_input(true)).text());
}

void FlightSequencer::tell_tracking(core::TimePoint now) {
  if (!tracking_.is_known() || tracking_said_) {
    return;
  }
  tracking_said_ = true;
  TextLine line;
  describe(line, tracking_);
  report(now, line.text());
}

/// A rival or a wrong attitude uses up the order; a check that is on trial lets it wait.
void FlightSequencer::refuse_for_pose(core::TimePoint now) {
  if (trial_said_) {
    return;
  }
  TextLine line;
  pose_.describe(line.add("control is not asked for: "), controller_, now);
  report(now, line.text());
  trial_said_ = true;
  order_given_ = order_given_ || !pose_.is_on_trial_only(now);
}

void FlightSequencer::report_stage(core::TimePoint now, const View& view) {
  if (reported_stage_ && view.stage == last_stage_ && view.reason == last_reason_) {
    return;
  }
  reported_stage_ = true;
  last_stage_ = view.stage;
  last_reason_ = view.reason;
  TextLine line;
  describe(line, view);
  if (view.reason == safety::AuthorityReason::kNothingReceived && controller_.link().health().echoes > 0) {
    line.add("; our own bytes come back: RX and TX are joined (half-duplex adapter, loopback plug?)");
  }
  report(now, line.text());
}

void FlightSequencer::report_failsafe(core::TimePoint now) {
  const std::uint32_t made = controller_.supervisor().stats().steps;
  if (made == reported_transitions_) {
    return;
  }
  reported_transitions_ = made;
  const safety::FailsafeStep& step = controller_.supervisor().last_step();
  if (step_count_ < steps_.size()) {
    steps_[step_count_++] = step;
  }
  TextLine line;
  line.add("failsafe: ").add(safety::name(step.from)).add(" to ").add(safety::name(step.to)).add(", ");
  line.add(safety::name(step.reason)).add(": ");
  describe(line, step.reason, step.seen, limits_);
  report(now, line.text());
}

void FlightSequencer::report_limit_cycle(core::TimePoint now) {
  const safety::Observation& seen = controller_.observed();
  if (seen.limit_cycle_detected && !limit_cycle_reported_) {
    limit_cycle_ = limit_cycle_ ? limit_cycle_ : seen;
    TextLine line;
    describe_limit_cycle(line, seen);
    report(now, line.text());
  }
  limit_cycle_reported_ = seen.limit_cycle_detected;
}

void FlightSequencer::report_return(core::TimePoint now) {
  using State = ReturnToStart<double>::State;
  const State state = home_.state();
  if (state != reported_return_ && state != State::kInactive) {
    TextLine line;
    line.add("battery low: ").add(static_cast<double>(controller_.link().telemetry().battery_percent), 0);
    line.add(" %, the limit is ").add(home_.low_percent(), 0).add(" %; ");
    line.add(state == State::kReturning ? "the aircraft flies to where the flight began"
                                        : "the aircraft is where the flight began");
    report(now, line.add(state == State::kReturning ? ", then the flight ends"
                         : request_.land            ? ", and lands"
                                                    : "; control goes back to the transmitter: land")
                    .text());
  }
  reported_return_ = state;
}

void FlightSequencer::report_excitation(core::TimePoint now) {
  const Excitation& excitation = controller_.excitation();
  if (excitation.state() == reported_excitation_) {
    return;
  }
  reported_excitation_ = excitation.state();
  TextLine line;
  describe(line, excitation);
  if (!line.text().empty()) {
    report(now, line.text());
  }
}

}  // namespace m100::companion
