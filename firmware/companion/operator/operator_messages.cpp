// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/operator/operator_messages.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "firmware/companion/operator/refusal_causes.h"
#include "firmware/core/maths.h"
#include "firmware/core/time.h"
#include "firmware/est/consistency/velocity_consistency.h"

namespace m100::companion {
namespace {

using safety::FailsafeReason;

/// Digits after the point, at least `least`, in which two digits of the smaller number matter, and in which the numbers
/// differ. Numbers that are a unit of the last digit apart are never rounded to the same.
int digits_of(double a, double b, int least) {
  int digits = std::max(least, TextLine::digits_of(std::min(std::abs(a), std::abs(b))));
  const double apart = std::abs(a - b);
  for (double unit = std::pow(10.0, -digits); digits < 9 && apart > 0.0 && apart < unit; unit /= 10.0) {
    ++digits;
  }
  return digits;
}

/// A residual and its limit: "0.012 m apart, allowed 0.0098 m".
TextLine& add_compared(TextLine& line, double residual, std::string_view how, double allowed, std::string_view unit,
                       int least = 2) {
  const int digits = digits_of(residual, allowed, least);
  return line.add(residual, digits)
      .add(" ")
      .add(unit)
      .add(how)
      .add(", allowed ")
      .add(allowed, digits)
      .add(" ")
      .add(unit);
}

TextLine& add_age(TextLine& line, std::string_view what, core::Duration age, core::Duration allowed) {
  if (age > std::chrono::hours(1)) {
    return line.add(what).add(": none has arrived");
  }
  return add_compared(line.add(what).add(": "), core::seconds<double>(age), "", core::seconds<double>(allowed), "s", 3);
}

/// Proposes the lever arm that explains the refusal.
void add_lever_arm(TextLine& line, const std::array<double, 3>& lever_b_m) {
  const auto& [forward_m, left_m, up_m] = lever_b_m;
  line.add("; the difference turns with the aircraft: a lever arm explains it. If the origin of the pose lies ");
  line.add(forward_m, 2).add(" m ahead and ").add(left_m, 2).add(" m left of the centre of gravity, set offset_m = [");
  line.add(forward_m, 2).add(", ").add(left_m, 2).add(", ").add(up_m, 2).add("] in [pose] of the flight file");
}

TextLine& add_refusal(TextLine& line, const safety::Observation& observed) {
  const est::ConsistencyStatus& seen = observed.consistency;
  const auto check = static_cast<est::ConsistencyCheck>(seen.contradicted_by);
  const bool of_attitude = check == est::ConsistencyCheck::kRates || check == est::ConsistencyCheck::kAnswer;
  line.add(of_attitude ? "attitude refused: " : "pose refused: ");
  if (check != est::ConsistencyCheck::kNone) {
    line.add(check == est::ConsistencyCheck::kAnswer  ? "it does not follow our commands, check "
             : check == est::ConsistencyCheck::kRates ? "the autopilot's rates contradict it, check "
                                                      : "the autopilot contradicts it, check ")
        .add(est::name(check))
        .add(": ");
    add_compared(line, seen.contradicted_with, " apart", seen.contradicted_allowed, est::unit_of(check));
  } else if (seen.refused_turn_rad > kHeadingGate_rad) {
    add_compared(line.add("turned by "), seen.refused_turn_rad, " from the prediction", kHeadingGate_rad, "rad");
  } else {
    add_compared(line, seen.refused_by_m, " from the prediction", seen.refused_allowed_m, "m");
  }
  const RefusalCauses causes(FailsafeReason::kPoseRefused, observed);
  if (!causes.list().empty() && causes.list().front() == RefusalCause::kLeverArm) {
    add_lever_arm(line, seen.lever_b_m);
  }
  return add_causes(line, causes);
}

TextLine& add_lost_estimate(TextLine& line, const safety::Observation& seen) {
  line.add("no estimate of the flight: newest pose ").add(core::seconds<double>(seen.estimate.pose_age), 2);
  line.add(" s old, telemetry ").add(core::seconds<double>(seen.link.telemetry_age), 2).add(" s");
  return add_causes(line, RefusalCauses(FailsafeReason::kEstimateLost, seen));
}

std::string_view failure_text(safety::FlightFailure failure) {
  constexpr std::array<std::string_view, 5> kTexts{
      // in the order of FlightFailure
      "no failure",
      "the aircraft is tilted by more than 45 degrees",
      "the aircraft tumbles: more than one revolution per second",
      "the aircraft falls: no thrust for 0.3 s",
      "crash: a tilt far from the commanded one for 2 s, or a shock and then no motion",
  };
  return kTexts[static_cast<std::size_t>(failure)];
}

TextLine& add_fence(TextLine& line, FailsafeReason reason, const safety::Observation& seen) {
  if (reason == FailsafeReason::kFenceLeft) {
    return line.add("the aircraft is ").add(seen.fence.outside_m, 2).add(" m outside its fence");
  }
  const int digits = digits_of(seen.estimate.error_m, seen.fence.reserve_m, 2);
  line.add("without a pose the position error may be ").add(seen.estimate.error_m, digits);
  return line.add(" m, and the fence leaves ").add(seen.fence.reserve_m, digits).add(" m");
}

/// The oscillation in degrees peak to peak, as an onlooker sees it.
TextLine& add_limit_cycle(TextLine& line, const safety::Observation& seen) {
  line.add("the aircraft swings by itself, by ")
      .add(seen.limit_cycle.height_rad * core::kRadian_deg, 0)
      .add(" degrees peak to peak, ");
  return line.add(seen.limit_cycle.frequency_hz, 1).add(" times a second");
}

}  // namespace

TextLine describe(const link::AuthorityView& authority) {
  const bool answered = authority.reason == safety::AuthorityReason::kAnswer;
  const std::string_view remedy = answered ? authority.answer.remedy : safety::remedy(authority.reason);
  TextLine line;
  line.add(safety::name(authority.stage)).add(" (").add(safety::name(authority.reason)).add(")");
  if (answered) {
    line.add(": ").add(authority.answer.name);
  }
  return line.add(remedy.empty() ? "" : "; ").add(remedy);
}

// Deviation: one sentence for each reason.
TextLine describe(FailsafeReason cause, const safety::Observation& seen, const safety::Limits& limits) {
  TextLine line;
  if (poses_are_refused(cause, seen)) {
    return add_refusal(line, seen);
  }
  switch (cause) {
    case FailsafeReason::kVibration:
      return describe_vibration(seen.consistency.vibration).add("; ").add(kVibrationRemedy);
    case FailsafeReason::kPoseOld:
      return add_age(line, "pose old", seen.estimate.pose_age, fresh_limit(limits, seen.pose_latency));
    case FailsafeReason::kTelemetryOld:
      return add_age(line, "telemetry old", seen.link.telemetry_age, limits.telemetry_stale);
    case FailsafeReason::kTelemetrySilent:
      return add_age(line, "telemetry silent", seen.link.telemetry_age, limits.telemetry_dead);
    case FailsafeReason::kEstimateLost:
      return add_lost_estimate(line, seen);
    case FailsafeReason::kControlGone:
      return line.add(seen.link.in_control ? "the mode switch left F" : "control is not ours any more");
    case FailsafeReason::kCommandInvalid:
      return line.add("the law's command was not finite or far out of range");
    case FailsafeReason::kCoastOver:
      return add_age(line, "no fresh pose while coasting; newest", seen.estimate.pose_age,
                     fresh_limit(limits, seen.pose_latency));
    case FailsafeReason::kReserveSpent:
    case FailsafeReason::kFenceLeft:
      return add_fence(line, cause, seen);
    case FailsafeReason::kAuthorityExceeded:
      line.add("the wind pushes with ").add(seen.wind.disturbance_acceleration_m_s2, 1).add(" m/s^2; the place has ");
      return line.add("not been held for ").add(core::seconds<double>(seen.wind.exceeded_for), 1).add(" s");
    case FailsafeReason::kLimitCycle:
      return add_limit_cycle(line, seen).add(", under the fallback law too: the law alone is not the cause");
    case FailsafeReason::kOnGround:
      line.add("the autopilot's flight status says \"on the ground\" for ");
      return line.add(core::seconds<double>(seen.flight.on_ground_for), 1).add(" s");
    case FailsafeReason::kFlightFailure:
      return line.add(failure_text(seen.flight.failure));
    case FailsafeReason::kTask:
      return line.add("the autopilot flies a task of its own, on the operator's command");
    case FailsafeReason::kGivenBack:
    case FailsafeReason::kEngaged:
      return line.add("on the operator's command")
          .add(cause == FailsafeReason::kGivenBack ? ", or because --hold is over" : "");
    case FailsafeReason::kLevelOver:
    case FailsafeReason::kNeutralOver:
      return line.add(cause == FailsafeReason::kLevelOver
                          ? "the cause has not cleared in the time allowed"
                          : "the time with neutral sticks is over; the transmitter gets control");
    case FailsafeReason::kPoseRefused:
    case FailsafeReason::kRecovered:
    case FailsafeReason::kNone:
      return line.add(cause == FailsafeReason::kNone ? "nothing stands in the way" : "poses are good again");
  }
  return line;
}

TextLine describe_vibration(const est::VibrationStatus& vibration) {
  TextLine line;
  line.add("vibration of the specific force above 15 Hz: ")
      .add_significant(vibration.rms_m_s2)
      .add(" m/s^2 rms on an axis, peak ");
  line.add_significant(vibration.peak_m_s2).add(" m/s^2");
  if (vibration.clipped > 0.0) {
    line.add(", ").add(100.0 * vibration.clipped, 0).add(" % of the readings at the end of the sensor's range");
  }
  line.add("; a healthy M100 shows 0.02 to 0.03 in flight. It can hide a false motion of ");
  return line.add_significant(3.0 * vibration.velocity_sigma_m_s).add(" m/s from the check of the poses");
}

TextLine describe_limit_cycle(const safety::Observation& seen) {
  TextLine line;
  return add_limit_cycle(line.add("swinging: "), seen)
      .add(
          "; the fallback law flies now, slower and less exact. Stop and land; poses or commands may be later than "
          "known, "
          "or "
          "the aircraft may respond more strongly than its vehicle file says: check with m100 doctor and m100-lab "
          "identify; m100-lab gains --tune makes the loop calmer");
}

TextLine describe(const ctl::Excitation<double>& excitation) {
  using State = ctl::Excitation<double>::State;
  constexpr std::array<std::string_view, ctl::kStickAxes> kSticks{"roll", "pitch", "throttle", "yaw"};
  constexpr std::string_view kLost = "control is lost, or the failsafe left its top state";
  constexpr std::array<std::string_view, 7> kAborts{
      // in the order of Abort
      kLost,
      kLost,
      "the aircraft would stop beyond the fence",
      "the aircraft would stop beyond the excitation's own distance",
      "the tilt is beyond its limit",
      "the speed is beyond its limit",
      "the law could not bring the aircraft to rest at its place",
  };
  const State state = excitation.state();
  TextLine line;
  if (state == State::kOver) {
    line.add("excitation: all ").add(static_cast<double>(excitation.piece()), 0).add(" pieces are flown");
  } else if (state == State::kMoving || state == State::kAborted) {
    line.add(state == State::kMoving ? "excitation: piece " : "excitation aborted at piece ");
    line.add(static_cast<double>(excitation.piece() + 1), 0).add(" on ");
    line.add(kSticks[static_cast<std::size_t>(excitation.axis())]);
  }
  if (state == State::kAborted) {
    line.add(": ").add(kAborts[static_cast<std::size_t>(excitation.abort())]);
    line.add("; ").add(excitation.distance(), 2).add(" m from its place at ").add(excitation.speed(), 2);
    line.add(" m/s. The law has all sticks");
  }
  return line;
}

}  // namespace m100::companion
