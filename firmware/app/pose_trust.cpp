// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/app/pose_trust.h"

#include <optional>

#include "firmware/core/maths.h"
#include "firmware/core/tilt.h"
#include "firmware/model/vehicle.h"

namespace m100::app {

namespace {

/// The speed still grows for a quarter of a second, until the tilt is reversed; a gust adds this much until the
/// aircraft answers it.
constexpr double kTurnsRound_s = 0.25, kGust_m_s = 0.4;

/// Distance between the poses and the observer's prediction from the reported attitude that has an innocent cause: per
/// speed the largest error of the time of capture that MotionCheck allows, and another 5 cm for noise and the lag after
/// a gust (1008 healthy flights: README of est). The mean is over a few poses.
constexpr double kMostLate_s = 0.12, kLag_m = 0.05, kPosesMean = 0.25;
constexpr double kSane = 1e6;  ///< resets the velocity if it is NaN, which would otherwise stay

/// Memory of the velocity from the commands: a trim error of half a degree is then 0.2 m/s. The shorter memory is for
/// the time while the pilot flies, who hovers when he is about to hand over.
constexpr double kAskedMemory_s = 2.0, kHoverMemory_s = 0.5, kMost_m_s = 20.0;

}  // namespace

template <typename T>
bool PoseTrust<T>::is_unanswered() const {
  const bool accuses =
      lied_to_ || poses_side_ || cross_check_.doubts() || cross_check_.report().check != est::Check::kNone;
  return (off_ & set_of(est::Check::kAnswer)) == 0 && accuses && answer_check_.is_unanswered();
}

template <typename T>
est::Contradiction<T> PoseTrust<T>::contradiction() const {
  if (rates_contradict()) {
    return {.check = est::Check::kRates, .measured = tilt_check_.apart_rad(), .allowed = tilt_check_.allowed_rad()};
  }
  if (is_unanswered()) {
    return {
        .check = est::Check::kAnswer, .measured = answer_check_.apart_rad(), .allowed = answer_check_.allowed_rad()};
  }
  return cross_check_.report();
}

/// Force and observer follow an attitude that was false before control was ours; the poses do not.
template <typename T>
void PoseTrust<T>::see(const est::Measurement<T>& measured, const est::Estimate<T>& estimate,
                       const core::Vector<T, 2>& asked_rad) {
  if (!measured.pose.is_new) {
    return;
  }
  using Vector2 = core::Vector<T, 2>;
  const Vector2 velocity_m_s(estimate.x.velocity_m_s, estimate.y.velocity_m_s);
  const Vector2 place_m = Vector2(estimate.x.position_m, estimate.y.position_m) -
                          velocity_m_s * core::seconds<T>(measured.pose.age(measured.now));
  seen_apart_m_ +=
      (measured.pose.position_w_m.template head<2>() - place_m - seen_apart_m_) * static_cast<T>(kPosesMean);
  if (!(seen_apart_m_.squaredNorm() < static_cast<T>(kSane))) {
    seen_apart_m_.setZero();
  }
  const Vector2 toward(asked_rad.x() - estimate.x.tilt_rad, estimate.y.tilt_rad - asked_rad.y());
  const T most_m = static_cast<T>(kLag_m) + static_cast<T>(kMostLate_s) * core::sqrt(velocity_m_s.squaredNorm());
  poses_side_ = seen_apart_m_.squaredNorm() > most_m * most_m && seen_apart_m_.dot(toward) > T(0);
}

template <typename T>
void PoseTrust<T>::update(const est::Felt<T>& felt, const est::Measurement<T>& measured,
                          const est::Estimate<T>& estimate, const core::Vector<T, 2>& asked_rad, safety::Rung rung,
                          core::Duration elapsed) {
  constexpr T kFar_m_s = T(0.5);
  see(measured, estimate, asked_rad);
  tilt_check_.update(felt, core::seconds<T>(elapsed));
  answer_check_.update(estimate, asked_rad, rung != safety::Rung::kSilent, core::seconds<T>(elapsed));
  cross_check_.update(felt, estimate, reckoning_.push_w_m_s2(), elapsed);
  const bool contradicted = contradiction().check != est::Check::kNone;
  const core::Vector<T, 2> apart =
      core::Vector<T, 2>(estimate.x.velocity_m_s, estimate.y.velocity_m_s) - reckoning_.velocity_w_m_s();
  const bool settles = rung == safety::Rung::kLevel || rung == safety::Rung::kRelease;
  const bool refused = settles && estimate.refused_poses > 0 && apart.squaredNorm() > kFar_m_s * kFar_m_s;
  lied_to_ = contradicted || refused || (lied_to_ && settles);
  const bool lay = tilt_lies_;
  tilt_lies_ = rates_contradict() || is_unanswered() || (tilt_lies_ && settles);
  const T speed_m_s = core::sqrt(reckoning_.velocity_w_m_s().squaredNorm());
  if (!lied_to_) {
    most_m_s_ = speed_m_s + static_cast<T>(kTurnsRound_s) * cross_check_.moved_m_s2() + static_cast<T>(kGust_m_s);
  }
  runs_away_ = settles && (speed_m_s > most_m_s_ || runs_away_);
  const bool trusted = !lied_to_ && !cross_check_.doubts() && estimate.refused_poses == 0;
  const bool pilots = rung == safety::Rung::kSilent;
  asked_rad_ = asked_rad + reckoning_.offset_rad();
  reckon_asked(estimate, trusted && !answer_check_.is_unanswered(), pilots, core::seconds<T>(elapsed));
  if (tilt_lies_ && !lay) {
    reckoning_.believe(asked_m_s_);
  }
  if (tilt_lies_) {
    reckoning_.update(as_asked(felt, estimate.yaw_rad), estimate, std::nullopt, trusted, pilots, elapsed);
  } else {
    reckoning_.update(felt, estimate, cross_check_.felt_h_m_s2(), trusted, pilots, elapsed);
  }
}

/// Computes the velocity from the commands, in addition to the reckoned velocity, whose attitude may have been false
/// for a while before this is noticed.
template <typename T>
void PoseTrust<T>::reckon_asked(const est::Estimate<T>& estimate, bool trusted, bool pilots, T step_s) {
  constexpr T kGravity_m_s2 = static_cast<T>(model::kGravity_m_s2);
  const core::Vector<T, 2> tilted_m_s2(kGravity_m_s2 * core::tan(asked_rad_.x()),
                                       -kGravity_m_s2 * core::tan(asked_rad_.y()));
  if (!(asked_m_s_.squaredNorm() < static_cast<T>(kSane))) {
    asked_m_s_.setZero();
  }
  asked_m_s_ += (tilted_m_s2 + reckoning_.push_w_m_s2()) * step_s;
  asked_m_s_ = asked_m_s_.cwiseMax(T(-kMost_m_s)).cwiseMin(T(kMost_m_s));
  if (pilots) {
    asked_m_s_ -= asked_m_s_ * (step_s * static_cast<T>(1.0 / kHoverMemory_s));
  } else if (trusted) {
    const core::Vector<T, 2> seen_m_s(estimate.x.velocity_m_s, estimate.y.velocity_m_s);
    asked_m_s_ += (seen_m_s - asked_m_s_) * (step_s * static_cast<T>(1.0 / kAskedMemory_s));
  }
}

/// Replaces the false tilt by the tilt that the model predicts from the commands.
template <typename T>
est::Felt<T> PoseTrust<T>::as_asked(const est::Felt<T>& felt, T yaw_rad) const {
  const core::Euler<T> asked = core::attitude_of(core::Tilt<T>{asked_rad_.x(), asked_rad_.y()}, yaw_rad);
  est::Felt<T> believed = felt;
  believed.attitude_is_new = true;
  believed.roll_rad = asked.roll_rad;
  believed.pitch_rad = asked.pitch_rad;
  return believed;
}

template <typename T>
est::Estimate<T> PoseTrust<T>::motion(const est::Estimate<T>& estimate) const {
  constexpr T kNotToBeUsed_m2_s2 = T(1e6);
  est::Estimate<T> known = lied_to_ ? reckoning_.instead_of(estimate) : estimate;
  if (tilt_lies_) {
    known.x.tilt_rad = asked_rad_.x();
    known.y.tilt_rad = asked_rad_.y();
  }
  if (runs_away_) {
    known.x.velocity_variance_m2_s2 = known.y.velocity_variance_m2_s2 = kNotToBeUsed_m2_s2;
  }
  return known;
}

template <typename T>
double PoseTrust<T>::speed_m_s(const est::Estimate<T>& estimate) const {
  constexpr T kWorthless_m2_s2 = T(1);
  const est::AxisEstimate<T>& x = estimate.x;
  const est::AxisEstimate<T>& y = estimate.y;
  const bool learned =
      lied_to_ || (x.velocity_variance_m2_s2 < kWorthless_m2_s2 && y.velocity_variance_m2_s2 < kWorthless_m2_s2);
  if (!estimate.predicts || runs_away_ || !learned) {
    return 0.0;
  }
  const core::Vector<T, 2> velocity_m_s =
      lied_to_ ? reckoning_.velocity_w_m_s() : core::Vector<T, 2>(x.velocity_m_s, y.velocity_m_s);
  return static_cast<double>(core::sqrt(velocity_m_s.squaredNorm()));
}

template <typename T>
double PoseTrust<T>::speed_then_m_s(const est::Estimate<T>& estimate, core::Duration later) const {
  constexpr T kGravity_m_s2 = static_cast<T>(model::kGravity_m_s2);
  const double now_m_s = speed_m_s(estimate);
  const est::Estimate<T> known = motion(estimate);
  const core::Vector<T, 2> velocity_m_s(known.x.velocity_m_s, known.y.velocity_m_s);
  const core::Vector<T, 2> push_m_s2(known.x.disturbance_m_s2 + kGravity_m_s2 * known.x.tilt_rad,
                                     known.y.disturbance_m_s2 - kGravity_m_s2 * known.y.tilt_rad);
  const bool grows = now_m_s > 0.0 && velocity_m_s.dot(push_m_s2) > T(0);  // zero: the speed is useless
  return grows ? static_cast<double>(core::sqrt((velocity_m_s + push_m_s2 * core::seconds<T>(later)).squaredNorm()))
               : now_m_s;
}

template <typename T>
void PoseTrust<T>::tell(safety::Observation& observed, const est::Estimate<T>& estimate,
                        core::Duration gate_shut) const {
  const est::Contradiction<T> contradicted = contradiction();
  observed.refused_poses = estimate.refused_poses;
  observed.refused_for = lied_to_ && estimate.refused_for < gate_shut ? gate_shut : estimate.refused_for;
  observed.refused_by_m = static_cast<double>(estimate.refusal.distance_m);
  observed.refused_allowed_m = static_cast<double>(estimate.refusal.allowed_m);
  observed.refused_turn_rad = static_cast<double>(estimate.refusal.turned_rad);
  observed.contradicted_by = static_cast<std::uint8_t>(contradicted.check);
  observed.contradicted_with = static_cast<double>(contradicted.measured);
  observed.contradicted_allowed = static_cast<double>(contradicted.allowed);
  observed.speed_m_s = speed_m_s(estimate);
}

template class PoseTrust<float>;
template class PoseTrust<double>;

}  // namespace m100::app
