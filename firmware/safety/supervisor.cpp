// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/safety/supervisor.h"

#include "firmware/core/maths.h"

namespace m100::safety {
namespace {

/// Finite and not absurd; NaN fails every comparison.
template <typename T>
bool sound(T value, double range) {
  return value >= static_cast<T>(-2.0 * range) && value <= static_cast<T>(2.0 * range);
}

}  // namespace

template <typename T>
Sign Supervisor<T>::weigh(const ctl::Command<T>& wanted, const Facts& facts) {
  Sign set = Sign::kNone;
  const auto add = [&set](bool holds, Sign fact) { set = holds ? set | fact : set; };
  const bool fresh = facts.pose_age <= limits_.pose_fresh && facts.telemetry_age <= limits_.telemetry_stale;
  good_ticks_ = fresh ? good_ticks_ + (good_ticks_ < limits_.good_ticks_to_recover ? 1U : 0U) : 0U;
  const core::Duration inside = facts.now - entered_;
  add(facts.authority && facts.mode_f, Sign::kCommandable);
  add(facts.operator_releases, Sign::kOperatorReleases);
  add(facts.telemetry_age > limits_.telemetry_dead, Sign::kTelemetryDead);
  add(!(sound(wanted.roll_rad, envelope_.tilt_rad) && sound(wanted.pitch_rad, envelope_.tilt_rad) &&
        sound(wanted.climb_m_s, envelope_.climb_m_s) && sound(wanted.yaw_rate_rad_s, envelope_.yaw_rate_rad_s)),
      Sign::kCommandUnsound);
  add(!facts.estimate_healthy || facts.refused_poses >= limits_.gate_shut_poses, Sign::kEstimateLost);
  add(fresh, Sign::kFresh);
  add(good_ticks_ >= limits_.good_ticks_to_recover, Sign::kRecovered);
  add(rung_ == Rung::kCoast && inside >= limits_.coast, Sign::kCoastOver);
  add(rung_ == Rung::kLevel && inside >= limits_.level, Sign::kLevelOver);
  add(rung_ == Rung::kRelease && inside >= limits_.neutral, Sign::kNeutralOver);
  add(facts.operator_engages, Sign::kOperatorEngages);
  add(facts.left_model[0], Sign::kRollLeftModel);
  add(facts.left_model[1], Sign::kPitchLeftModel);
  add(facts.left_model[2], Sign::kYawRateLeftModel);
  add(facts.left_model[3], Sign::kClimbLeftModel);
  add(facts.trim_drifted, Sign::kTrimDrifted);
  return set;
}

template <typename T>
void Supervisor<T>::enter(Rung rung, core::TimePoint now) {
  rung_ = rung;
  entered_ = now;
  stats_.coasts += rung == Rung::kCoast ? 1U : 0U;
  stats_.levels += rung == Rung::kLevel ? 1U : 0U;
  stats_.releases += rung == Rung::kRelease ? 1U : 0U;
  good_ticks_ = rung == Rung::kCoast ? 0 : good_ticks_;  // ten good ticks are counted from the fault on
}

template <typename T>
T Supervisor<T>::limited(T wanted, T last, double range, double slew, T step_s) {
  const T most = static_cast<T>(slew) * step_s;
  const T inside = core::clamp(wanted, static_cast<T>(-range), static_cast<T>(range));
  const T reached = core::clamp(inside, last - most, last + most);
  stats_.limited_commands += reached != wanted ? 1U : 0U;
  return reached;
}

template <typename T>
ctl::Command<T> Supervisor<T>::limited(const ctl::Command<T>& wanted, T step_s) {
  const Envelope& e = envelope_;
  return {.roll_rad = limited(wanted.roll_rad, last_.roll_rad, e.tilt_rad, e.tilt_slew_rad_s, step_s),
          .pitch_rad = limited(wanted.pitch_rad, last_.pitch_rad, e.tilt_rad, e.tilt_slew_rad_s, step_s),
          .climb_m_s = limited(wanted.climb_m_s, last_.climb_m_s, e.climb_m_s, e.climb_slew_m_s2, step_s),
          .yaw_rate_rad_s =
              limited(wanted.yaw_rate_rad_s, last_.yaw_rate_rad_s, e.yaw_rate_rad_s, e.yaw_slew_rad_s2, step_s)};
}

template <typename T>
Grant<T> Supervisor<T>::review(const ctl::Command<T>& wanted, const Facts& facts, T step_s) {
  seen_ = weigh(wanted, facts);
  stats_.unsound_commands += has_any(seen_, Sign::kCommandUnsound) ? 1U : 0U;
  const Rung before = rung_;
  const Rung after = next_rung(rung_, seen_);
  if (after != before) {
    enter(after, facts.now);
  }
  const bool passes = passes_law(rung_) && !has_any(seen_, Sign::kCommandUnsound);
  last_ = limited(passes ? wanted : ctl::Command<T>{}, step_s);
  return {.command = last_,
          .rung = rung_,
          .transmit = may_transmit(rung_),
          .release = before == Rung::kRelease && after == Rung::kSilent && has_any(seen_, Sign::kCommandable)};
}

template class Supervisor<float>;
template class Supervisor<double>;

}  // namespace m100::safety
