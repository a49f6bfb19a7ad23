// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/fly/flight_reporter.h"

#include <algorithm>

#include "firmware/companion/operator/operator_messages.h"
#include "firmware/core/maths.h"

namespace m100::companion {
namespace {

using Excitation = ctl::Excitation<double>;

/// Raises the ages, the distances and the time of exceeded wind in `worst` to those in `by`, where these are larger.
void raise(safety::Observation& worst, const safety::Observation& by) {
  worst.estimate.pose_age = std::max(worst.estimate.pose_age, by.estimate.pose_age);
  worst.link.telemetry_age = std::max(worst.link.telemetry_age, by.link.telemetry_age);
  worst.fence.outside_m = std::max(worst.fence.outside_m, by.fence.outside_m);
  worst.consistency.refused_by_m = std::max(worst.consistency.refused_by_m, by.consistency.refused_by_m);
  worst.wind.exceeded_for = std::max(worst.wind.exceeded_for, by.wind.exceeded_for);
  if (by.consistency.lever_b_m != std::array<double, 3>{}) {  // the longer it turns, the better it is known
    worst.consistency.lever_b_m = by.consistency.lever_b_m;
  }
}

}  // namespace

void FlightReporter::update(core::TimePoint now, bool is_flying) {
  report_stage(now);
  report_failsafe(now);
  report_excitation(now);
  report_limit_cycle(now);
  report_heading(now);
  report_jump(now);
  report_vibration(now, is_flying);
  note_flight(now, is_flying);
}

/// Updates the tracking error, and the largest ages and distances since the failsafe was last nominal.
void FlightReporter::note_flight(core::TimePoint now, bool is_flying) {
  const safety::FailsafeState failsafe_state = controller_.supervisor().failsafe_state();
  const bool passes =
      failsafe_state == safety::FailsafeState::kNominal || failsafe_state == safety::FailsafeState::kCoast;
  if (is_flying && passes) {
    const est::Estimate<double>& at = controller_.estimate();
    tracking_.update(now, {at.x.position_m, at.y.position_m, at.height_m}, controller_.reference(),
                     controller_.law().lead());
  }
  if (failsafe_state == safety::FailsafeState::kNominal) {
    worst_ = controller_.observed();
  } else {
    raise(worst_, controller_.observed());
  }
}

safety::Observation FlightReporter::worst_since(const safety::Observation& step) const {
  safety::Observation worst = step;
  raise(worst, worst_);
  return worst;
}

void FlightReporter::report_tracking(core::TimePoint now) {
  if (!tracking_.is_known() || tracking_reported_) {
    return;
  }
  tracking_reported_ = true;
  operator_log_.write(now, describe(tracking_).text());
}

void FlightReporter::report_stage(core::TimePoint now) {
  const link::AuthorityView& view = controller_.link().authority();
  if (reported_stage_ && view.stage == last_stage_ && view.reason == last_reason_) {
    return;
  }
  reported_stage_ = true;
  last_stage_ = view.stage;
  last_reason_ = view.reason;
  TextLine line = describe(view);
  if (view.reason == safety::AuthorityReason::kNothingReceived && controller_.link().health().echoes > 0) {
    line.add("; our own bytes come back: RX and TX are joined (half-duplex adapter, loopback plug?)");
  }
  operator_log_.write(now, line.text());
}

void FlightReporter::report_failsafe(core::TimePoint now) {
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
  line.add(safety::name(step.reason)).add(": ").add(describe(step.reason, step.seen, limits_));
  operator_log_.write(now, line.text());
}

void FlightReporter::report_limit_cycle(core::TimePoint now) {
  const safety::Observation& seen = controller_.observed();
  if (seen.limit_cycle.detected && !limit_cycle_reported_) {
    limit_cycle_ = limit_cycle_ ? limit_cycle_ : seen;
    operator_log_.write(now, describe_limit_cycle(seen).text());
  }
  limit_cycle_reported_ = seen.limit_cycle.detected;
}

void FlightReporter::report_heading(core::TimePoint now) {
  const double turned_rad = controller_.heading_turned_alone_rad();
  if (turned_rad > 0.0 && !reported_.heading) {
    TextLine line;
    line.add("the autopilot's heading jumped by ").add(turned_rad * core::kRadian_deg, 0);
    operator_log_.write(now, line.add(" degrees; its gyroscopes and the poses show no such turn: its compass is "
                                      "disturbed, or its estimate was reset. The flight uses the heading of the poses")
                                 .text());
  }
  reported_.heading = turned_rad > 0.0;
}

/// Reported once.
void FlightReporter::report_vibration(core::TimePoint now, bool is_flying) {
  const est::VibrationStatus& seen = controller_.observed().consistency.vibration;
  if (seen.velocity_sigma_m_s >= kReportedVibration_m_s && !reported_.vibration) {
    reported_.vibration = true;
    operator_log_.write(now, describe_vibration(seen).add("; ").add(kVibrationRemedy).text());
  }
  if (is_flying && seen.velocity_sigma_m_s > vibration_.velocity_sigma_m_s) {
    vibration_ = seen;
  }
}

void FlightReporter::report_task(core::TimePoint now, const AutopilotTask& task, bool outside) {
  using State = AutopilotTask::State;
  TextLine line;
  if (task.state() == State::kFailed) {
    line.add(describe(task)).add("; control goes back to the transmitter");
  } else if (task.state() == State::kWouldDrift) {
    line.add(
        "the wind would carry the autopilot's landing away: the law hovers here for 10 s, then control goes back; ");
    line.add("land by hand");
  } else if (task.state() != State::kDone) {
    line.add(name(task.task())).add(" ordered: the autopilot flies it as its own task; the pilot's switch ends it");
  } else if (task.task() == protocol::Task::kLand) {
    line.add("landed: by the autopilot's flight status, the aircraft is on the ground");
  } else if (outside) {
    line.add("taken off, and the aircraft is outside its fence: it brakes, then control goes back");
  } else {
    line.add("taken off: by the autopilot's flight status, the aircraft is in the air; the law takes over");
  }
  operator_log_.write(now, line.text());
}

void FlightReporter::report_refusal(core::TimePoint now, std::string_view how, const link::AuthorityView& authority,
                                    std::string_view next) {
  TextLine line;
  operator_log_.write(now, line.add(how).add(describe(authority)).add(next.empty() ? "" : "; ").add(next).text());
}

void FlightReporter::report_landing(core::TimePoint now) {
  TextLine line;
  line.add("the autopilot lands by itself: its flight status says \"landing\" for 0.5 s and nobody ordered it; ");
  line.add("battery ").add(static_cast<double>(controller_.link().telemetry().battery_percent), 0);
  operator_log_.write(now, line.add(" %; the course ends and control goes back to the transmitter").text());
}

void FlightReporter::report_jump(core::TimePoint now) {
  const app::AnnouncedJump& jump = controller_.source_frame().jump();
  if (jump.count == reported_.jumps) {
    return;
  }
  reported_.jumps = jump.count;
  const auto& [x, y, z] = jump.by_m;
  TextLine line;
  line.add("the pose source announced a jump of its world (reset_counter) by ");
  line.add(x, 2).add(", ").add(y, 2).add(", ").add(z, 2).add(" m");
  if (jump.turned_rad != 0.0) {
    line.add(" and ").add(jump.turned_rad * core::kRadian_deg, 0).add(" degrees");
  }
  line.add("; the course goes with it, and the fence is what the old and the moved box share");
  operator_log_.write(now, line.text());
  core::TimePoint& nine_before = reported_.jumps_at[jump.count % reported_.jumps_at.size()];
  if (nine_before != core::TimePoint{} && now - nine_before <= std::chrono::minutes(1)) {
    operator_log_.write(now,
                        "ten jumps of the pose source in a minute: it does not know where it is; land, and check "
                        "what it sees");
    reported_.jumps_at.fill({});
  }
  nine_before = now;
}

void FlightReporter::update_return(const ReturnToStart<double>& home, core::TimePoint now) {
  using State = ReturnToStart<double>::State;
  const State state = home.state();
  if (state != reported_return_ && state != State::kInactive) {
    TextLine line;
    line.add("battery low: ").add(static_cast<double>(controller_.link().telemetry().battery_percent), 0);
    line.add(" %, the limit is ").add(home.low_percent(), 0).add(" %; ");
    line.add(state == State::kReturning ? "the aircraft flies to where the flight began"
                                        : "the aircraft is where the flight began");
    operator_log_.write(now, line.add(state == State::kReturning ? ", then the flight ends"
                                      : lands_                   ? ", and lands"
                                                                 : "; control goes back to the transmitter: land")
                                 .text());
  }
  reported_return_ = state;
}

void FlightReporter::report_excitation(core::TimePoint now) {
  const Excitation& excitation = controller_.excitation();
  if (excitation.state() == reported_excitation_) {
    return;
  }
  reported_excitation_ = excitation.state();
  if (const TextLine line = describe(excitation); !line.text().empty()) {
    operator_log_.write(now, line.text());
  }
}

void FlightReporter::report_end(core::TimePoint now, const link::AuthorityView& authority,
                                std::optional<safety::FailsafeReason> denial, bool takes_off, std::string_view next) {
  TextLine line;
  line.add("the flight has ended: ");
  if (authority.stage != safety::AuthorityStage::kReleasing && authority.reason != safety::AuthorityReason::kReleased) {
    line.add(describe(authority));
  } else if (denial) {
    line.add(takes_off ? "the law has not flown; " : "control was not used; ");
    line.add(describe(*denial, controller_.observed(), limits_));
  } else {
    const safety::FailsafeStep& step = controller_.supervisor().descent();
    line.add(describe(step.reason, worst_since(step.seen), limits_)).add("; control goes back to the transmitter");
  }
  operator_log_.write(now, line.add("; ").add(next).text());
}

}  // namespace m100::companion
