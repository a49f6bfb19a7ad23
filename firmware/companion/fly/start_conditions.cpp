// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/fly/start_conditions.h"

#include "firmware/companion/fly/autopilot_task.h"
#include "firmware/companion/operator/denial.h"
#include "firmware/companion/operator/operator_messages.h"

namespace m100::companion {
namespace {

/// An obstacle that lasts longer is reported.
constexpr core::Duration kObstacleReported = std::chrono::seconds(1);

}  // namespace

/// Whether the aircraft is too far from where the flight must begin: the course's beginning or, for a take-off, where
/// it stood. False if something other than the fence prevents flying, or after a flight to goals (not for a take-off).
bool StartConditions::is_out_of_reach(bool takes_off) const {
  const est::Estimate<double>& at = controller_.estimate();
  const core::Vector<double, 3>& from = takes_off ? request_.takeoff_position_w_m : request_.course_start_w_m;
  const core::Vector<double, 3> away{at.x.position_m - from.x(), at.y.position_m - from.y(), at.height_m - from.z()};
  const bool is_known = is_outside(takes_off) || denial(takes_off) == safety::FailsafeReason::kNone;
  const bool is_bound = takes_off || !goal_led_;
  return is_known && is_bound && away.squaredNorm() > request_.max_start_distance_m * request_.max_start_distance_m;
}

bool StartConditions::on_ground(core::TimePoint now) const {
  return request_.take_off && is_on_ground(controller_.link(), now).value_or(false);
}

bool StartConditions::is_outside(bool takes_off) const {
  return denial(takes_off) == safety::FailsafeReason::kFenceLeft;
}

bool StartConditions::is_ready(core::TimePoint now) const {
  // A take-off needs to know whether the aircraft is on the ground or in the air.
  const bool is_known = !request_.take_off || is_on_ground(controller_.link(), now).has_value();
  return controller_.link().authority().stage == safety::AuthorityStage::kReady && is_known && is_clear(now) &&
         !pose_blocks(now);
}

/// Before the first telemetry package the reason is kTelemetryOld. A place outside the fence, or on the ground, does
/// not prevent a take-off, and neither does the shaking of idling rotors.
safety::FailsafeReason StartConditions::denial(bool takes_off) const {
  if (controller_.link().health().packages == 0) {
    return safety::FailsafeReason::kTelemetryOld;
  }
  const safety::FailsafeReason cause = denial_reason(controller_.observed(), limits_);
  const bool of_ground = cause == safety::FailsafeReason::kFenceLeft || cause == safety::FailsafeReason::kOnGround ||
                         cause == safety::FailsafeReason::kVibration;
  return takes_off && of_ground ? safety::FailsafeReason::kNone : cause;
}

bool StartConditions::report_impossible(core::TimePoint now, bool backed_up, bool program_ends) const {
  TextLine line;
  if (!backed_up) {
    line.add("control is not asked for: nobody would give it back if this program died; end m100 and start it again");
  } else if (request_.take_off && !is_on_ground(controller_.link(), now)) {
    line.add("control was not asked for: without the autopilot's flight status it is not known whether the aircraft ");
    line.add("is on the ground; ").add(next_input(program_ends));
  }
  if (!line.text().empty()) {
    operator_log_.write(now, line.text());
  }
  return !line.text().empty();
}

void StartConditions::report_awaited(core::TimePoint now, bool waits) {
  const safety::FailsafeReason cause = controller_.link().authority().stage == safety::AuthorityStage::kReady
                                           ? denial(on_ground(now))
                                           : safety::FailsafeReason::kNone;
  if (cause == safety::FailsafeReason::kNone || !waits) {
    clear_ = now;
    reported_denial_ = safety::FailsafeReason::kNone;
    return;
  }
  if (now - clear_ > kObstacleReported && reported_denial_ == safety::FailsafeReason::kNone) {
    reported_denial_ = cause;
    TextLine line;
    line.add("control is not asked for yet; ").add(describe(cause, controller_.observed(), limits_));
    add_refused_poses(line, cause, now);
    operator_log_.write(now, line.add(": ").add(remedy_for(cause)).text());
  }
}

/// Adds why poses were refused within the last second, if the cause is an old pose or a lost estimate.
void StartConditions::add_refused_poses(TextLine& line, safety::FailsafeReason cause, core::TimePoint now) const {
  const link::PoseLinkStats& poses = controller_.pose_link().stats();
  const bool is_lately = poses.last_fault != link::PoseFault::kNone && now - poses.last_fault_at < kObstacleReported;
  if (is_lately && (cause == safety::FailsafeReason::kPoseOld || cause == safety::FailsafeReason::kEstimateLost)) {
    line.add("; poses come and are refused: ").add(link::text_of(poses.last_fault).sentence);
    if (poses.last_fault == link::PoseFault::kVariance) {
      line.add(" (it states ").add(poses.last_variance_m2, 2).add(" m^2)");
    }
  }
}

bool StartConditions::report_pose(core::TimePoint now, bool again) {
  if (pose_reported_ && !again) {
    return false;
  }
  TextLine line;
  pose_.describe(line.add("control is not asked for: "), controller_, now);
  operator_log_.write(now, line.text());
  pose_reported_ = true;
  return !pose_.is_on_trial_only(now);
}

void StartConditions::report_position(core::TimePoint now, bool takes_off, bool program_ends) const {
  if (is_outside(takes_off)) {
    report_denial(now, safety::FailsafeReason::kFenceLeft, program_ends);
  } else {
    report_distance(now, takes_off, program_ends);
  }
}

void StartConditions::report_denial(core::TimePoint now, safety::FailsafeReason cause, bool program_ends) const {
  TextLine line;
  line.add("control is not taken; ").add(describe(cause, controller_.observed(), limits_));
  add_refused_poses(line, cause, now);
  operator_log_.write(now, line.add(": ").add(remedy_for(cause)).add("; ").add(next_input(program_ends)).text());
}

void StartConditions::report_distance(core::TimePoint now, bool takes_off, bool program_ends) const {
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
  operator_log_.write(now, line.add(" m: fly there, or start m100 again here; ").add(next_input(program_ends)).text());
}

}  // namespace m100::companion
