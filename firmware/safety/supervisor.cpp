// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/safety/supervisor.h"

#include "firmware/core/assert.h"
#include "firmware/core/maths.h"

namespace m100::safety {
namespace {

/// Tolerance of the tilt limit: a law that keeps the same limit in float must not be cut because of its last bits.
constexpr double kTiltRounding_rad = 1e-4;
/// Least time in COAST before a spent reserve ends it. Until then the aircraft brakes, and flies on if poses come back.
constexpr core::Duration kFlownThrough = std::chrono::milliseconds(500);
/// Largest error of the acceleration from which the speed is computed while no pose shows it: the offset of the
/// specific force (est::kForceOffset_m_s2).
constexpr double kUnseen_m_s2 = 0.2;

/// At most twice the range; false for NaN, which fails every comparison.
template <typename T>
bool sound(T value, T range) {
  return value >= T(-2) * range && value <= T(2) * range;
}

}  // namespace

template <typename T>
bool Supervisor<T>::is_valid(const ctl::Command<T>& command) const {
  return sound(command.roll_rad, envelope_.tilt_rad) && sound(command.pitch_rad, envelope_.tilt_rad) &&
         sound(command.climb_m_s, envelope_.climb_m_s) && sound(command.yaw_rate_rad_s, envelope_.yaw_rate_rad_s);
}

template <typename T>
bool Supervisor<T>::is_inside(const ctl::Command<T>& command) const {
  const auto inside = [](T value, T range) { return value >= -range && value <= range; };
  return inside(command.roll_rad, envelope_.tilt_rad) && inside(command.pitch_rad, envelope_.tilt_rad) &&
         inside(command.climb_m_s, envelope_.climb_m_s) && inside(command.yaw_rate_rad_s, envelope_.yaw_rate_rad_s);
}

/// Counts each pose once: a pose is new if its time of capture has changed by 1 ms or more.
template <typename T>
void Supervisor<T>::count_good_poses(const Observation& seen, bool fresh) {
  constexpr core::Duration kNewer = std::chrono::milliseconds(1);  // estimates of one time of capture differ by less
  if (!fresh) {
    good_poses_ = 0;
    return;
  }
  const core::TimePoint captured = seen.now - seen.estimate.pose_age;
  const core::Duration moved = captured - last_capture_;
  if (moved < kNewer && moved > -kNewer) {
    return;
  }
  last_capture_ = captured;
  good_poses_ += good_poses_ < limits_.good_poses_to_recover ? 1U : 0U;
}

/// The time of a state begins anew in kLevel while a task flies, and in kCoast when fresh poses, none of them refused,
/// have made the observer's error no larger than it was when kCoast began. In kCoast the aircraft brakes as in kLevel
/// from the moment at which the error exceeds GeofenceStatus::reserve_m; if kLevel follows, its time begins there.
template <typename T>
void Supervisor<T>::update_times(const Observation& seen, bool fresh) {
  const bool coasts = failsafe_state_ == FailsafeState::kCoast;
  const bool is_known =
      fresh && seen.consistency.refused_poses == 0 && seen.estimate.error_m <= last_step_.seen.estimate.error_m;
  if ((coasts && is_known) || (failsafe_state_ == FailsafeState::kLevel && seen.orders.task_flies)) {
    since_ = seen.now;
  }
  if (!coasts || is_known) {
    braking_since_.reset();
  } else if (!braking_since_ && seen.estimate.error_m > seen.fence.reserve_m) {
    braking_since_ = seen.now;
  }
}

/// Does not count in kSilent, where the pilot flies, or the legs and the idling rotors shake.
template <typename T>
bool Supervisor<T>::vibration_hides_faults(const Observation& seen) const {
  return failsafe_state_ != FailsafeState::kSilent &&
         hides_false_poses(limits_, seen.consistency.vibration.velocity_sigma_m_s);
}

template <typename T>
FailsafeCondition Supervisor<T>::weigh(const ctl::Command<T>& wanted, const Observation& seen) {
  FailsafeCondition set = FailsafeCondition::kNone;
  const auto add = [&set](bool holds, FailsafeCondition sign) { set |= when(holds, sign); };
  const bool fresh = seen.estimate.pose_age <= fresh_limit(limits_, seen.pose_latency) &&
                     seen.link.telemetry_age <= limits_.telemetry_stale;
  count_good_poses(seen, fresh);
  update_times(seen, fresh);
  const core::Duration inside = seen.now - since_;
  const bool sees = fresh && seen.consistency.refused_for < limits_.gate_shut;  // refused poses show no speed
  const core::Duration most_level = sees ? limits_.level_moving_seen : limits_.level_moving;
  const double unseen_m_s = sees ? 0.0 : kUnseen_m_s2 * core::seconds<double>(seen.estimate.pose_age);
  // The larger of the present speed and the speed at the hand-over decides: a wind may accelerate the aircraft until
  // the pilot has the sticks.
  const double speed_m_s = seen.consistency.speed_then_m_s > seen.consistency.speed_m_s
                               ? seen.consistency.speed_then_m_s
                               : seen.consistency.speed_m_s;
  const bool may_hand_over = speed_m_s + unseen_m_s < limits_.hand_over_m_s || inside >= most_level;
  add(seen.link.in_control && seen.link.mode_f, FailsafeCondition::kCommandable);
  add(seen.orders.releases, FailsafeCondition::kOperatorReleases);
  add(seen.link.telemetry_age > limits_.telemetry_dead, FailsafeCondition::kTelemetryDead);
  add(!is_valid(wanted), FailsafeCondition::kCommandInvalid);
  const bool lost = !seen.estimate.healthy || seen.consistency.refused_for >= limits_.gate_shut;
  add(lost || vibration_hides_faults(seen), FailsafeCondition::kEstimateLost);
  add(fresh, FailsafeCondition::kFresh);
  add(good_poses_ >= limits_.good_poses_to_recover, FailsafeCondition::kRecovered);
  add(failsafe_state_ == FailsafeState::kCoast && inside >= limits_.coast, FailsafeCondition::kCoastOver);
  add(braking_since_ && inside >= kFlownThrough, FailsafeCondition::kReserveSpent);
  add(seen.fence.outside_m > 0.0, FailsafeCondition::kOutsideFence);
  add(seen.wind.exceeded_for >= limits_.authority_exceeded, FailsafeCondition::kAuthorityExceeded);
  add(failsafe_state_ == FailsafeState::kLevel && inside >= limits_.level && may_hand_over,
      FailsafeCondition::kLevelOver);
  add(failsafe_state_ == FailsafeState::kRelease && inside >= limits_.neutral, FailsafeCondition::kNeutralOver);
  add(seen.orders.engages, FailsafeCondition::kOperatorEngages);
  add(seen.orders.task_flies, FailsafeCondition::kTaskFlies);
  add(seen.flight.on_ground_for >= (lost ? limits_.on_ground / 2 : limits_.on_ground), FailsafeCondition::kOnGround);
  add(seen.flight.failure != FlightFailure::kNone, FailsafeCondition::kFlightFailure);
  add(seen.model.mismatch[0], FailsafeCondition::kRollModelMismatch);
  add(seen.model.mismatch[1], FailsafeCondition::kPitchModelMismatch);
  add(seen.model.mismatch[2], FailsafeCondition::kYawRateModelMismatch);
  add(seen.model.mismatch[3], FailsafeCondition::kClimbModelMismatch);
  add(seen.model.trim_drifted, FailsafeCondition::kTrimDrifted);
  add(seen.limit_cycle.detected, FailsafeCondition::kLimitCycle);
  add(seen.limit_cycle.persists, FailsafeCondition::kLimitCyclePersists);
  return set;
}

template <typename T>
FailsafeReason Supervisor<T>::reason_of(const FailsafeTransition& row, const Observation& seen) const {
  if (row.why == FailsafeReason::kEstimateLost && seen.estimate.healthy) {
    return vibration_hides_faults(seen) ? FailsafeReason::kVibration : FailsafeReason::kPoseRefused;
  }
  if (row.why == FailsafeReason::kPoseOld && seen.estimate.pose_age <= fresh_limit(limits_, seen.pose_latency)) {
    return FailsafeReason::kTelemetryOld;
  }
  return row.why;
}

template <typename T>
void Supervisor<T>::enter(const FailsafeTransition& row, const Observation& seen) {
  last_step_ = {.from = failsafe_state_, .to = row.to, .reason = reason_of(row, seen), .seen = seen};
  const bool is_descent = failsafe_state_ == FailsafeState::kNominal ||
                          (failsafe_state_ == FailsafeState::kCoast && last_step_.reason != FailsafeReason::kCoastOver);
  descent_ = is_descent && row.to != FailsafeState::kNominal ? last_step_ : descent_;
  since_ = row.to == FailsafeState::kLevel ? braking_since_.value_or(seen.now) : seen.now;
  failsafe_state_ = row.to;
  stats_.steps += 1U;
  stats_.coasts += failsafe_state_ == FailsafeState::kCoast ? 1U : 0U;
  stats_.levels += failsafe_state_ == FailsafeState::kLevel ? 1U : 0U;
  stats_.releases += failsafe_state_ == FailsafeState::kRelease ? 1U : 0U;
  good_poses_ =
      failsafe_state_ == FailsafeState::kCoast ? 0 : good_poses_;  // ten good poses are counted after the fault
}

template <typename T>
T Supervisor<T>::limited(T wanted, T last, T range, T slew, T step_s) {
  const T most = slew * step_s;
  const T inside = core::clamp(wanted, -range, range);
  const T reached = core::clamp(inside, last - most, last + most);
  stats_.limited_commands += reached != wanted ? 1U : 0U;
  return reached;
}

// Limits both axes together: each at its own limit would tilt the aircraft by 1.4 times as much.
template <typename T>
ctl::Command<T> Supervisor<T>::limit_tilt(const ctl::Command<T>& wanted) {
  const T most = envelope_.tilt_rad;
  const T square = wanted.roll_rad * wanted.roll_rad + wanted.pitch_rad * wanted.pitch_rad;
  // cos(tilt) = cos(roll) cos(pitch). This tilt is slightly below the root of the squares.
  if (square <= most * most ||
      core::cos(wanted.roll_rad) * core::cos(wanted.pitch_rad) >= core::cos(most + static_cast<T>(kTiltRounding_rad))) {
    return wanted;
  }
  const T share = most / core::sqrt(square);
  ctl::Command<T> inside = wanted;
  inside.roll_rad *= share;
  inside.pitch_rad *= share;
  stats_.limited_commands += 1;
  return inside;
}

template <typename T>
ctl::Command<T> Supervisor<T>::limited(const ctl::Command<T>& wanted, T step_s) {
  const EnvelopeIn<T>& e = envelope_;
  const ctl::Command<T> inside = limit_tilt(wanted);
  return {.roll_rad = limited(inside.roll_rad, last_.roll_rad, e.tilt_rad, e.tilt_slew_rad_s, step_s),
          .pitch_rad = limited(inside.pitch_rad, last_.pitch_rad, e.tilt_rad, e.tilt_slew_rad_s, step_s),
          .climb_m_s = limited(wanted.climb_m_s, last_.climb_m_s, e.climb_m_s, e.climb_slew_m_s2, step_s),
          .yaw_rate_rad_s =
              limited(wanted.yaw_rate_rad_s, last_.yaw_rate_rad_s, e.yaw_rate_rad_s, e.yaw_slew_rad_s2, step_s)};
}

template <typename T>
CommandSource Supervisor<T>::update_failsafe(const ctl::Command<T>& wanted, const Observation& seen) {
  if (&seen != &observed_) {
    observed_ = seen;
  }
  const FailsafeCondition conditions_before = conditions_;
  conditions_ = weigh(wanted, seen);
  const bool unsound = any(conditions_, FailsafeCondition::kCommandInvalid);
  stats_.invalid_commands += unsound ? 1U : 0U;
  const FailsafeState before = failsafe_state_;
  if (before != row_state_ || conditions_ != conditions_before) {  // otherwise the table gives the same row again
    row_ = row_number(before, conditions_);
    row_state_ = before;
  }
  if (row_ < kFailsafeTransitions.size()) {
    enter(kFailsafeTransitions[row_], seen);
  }
  ended_ = before != FailsafeState::kSilent && failsafe_state_ == FailsafeState::kSilent &&
           any(conditions_, FailsafeCondition::kCommandable);
  // In kRelease after kLevel the aircraft is still held, because with level sticks a wind would accelerate it.
  const bool stands = failsafe_state_ == FailsafeState::kRelease && last_step_.from == FailsafeState::kLevel;
  const bool brakes =
      failsafe_state_ == FailsafeState::kLevel || (failsafe_state_ == FailsafeState::kCoast && braking_since_);
  const CommandSource passes = brakes || stands              ? CommandSource::kBrakeAndHold
                               : passes_law(failsafe_state_) ? CommandSource::kLaw
                                                             : CommandSource::kNeutral;
  return unsound ? CommandSource::kNeutral : passes;
}

template <typename T>
SupervisedCommand<T> Supervisor<T>::limit_command(CommandSource passes, const ctl::Command<T>& command, T step_s) {
  const bool passes_one =
      passes == CommandSource::kLaw || (passes == CommandSource::kBrakeAndHold && is_valid(command));
  M100_ASSERT(step_s >= T(0));
  last_ = limited(passes_one ? command : ctl::Command<T>{}, step_s);
  M100_ASSERT(is_inside(last_));  // R5: the last place at which a wrong number can be kept from the wire
  return {.command = last_,
          .failsafe_state = failsafe_state_,
          .transmit = may_transmit(failsafe_state_),
          .release = ended_};
}

template class Supervisor<float>;
template class Supervisor<double>;

}  // namespace m100::safety
