// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/app/pose_trust.h"

#include "firmware/core/maths.h"

namespace m100::app {

namespace {

/// For a quarter of a second, until the tilt has turned round, the speed still grows; and what a gust adds until it is
/// answered.
constexpr double kTurnsRound_s = 0.25, kGust_m_s = 0.4;

}  // namespace

template <typename T>
est::Contradiction<T> PoseTrust<T>::contradiction() const {
  return rates_contradict() ? est::Contradiction<T>{.check = est::Check::kRates,
                                                    .measured = tilt_check_.apart_rad(),
                                                    .allowed = tilt_check_.allowed_rad()}
                            : cross_check_.report();
}

template <typename T>
void PoseTrust<T>::update(const est::Felt<T>& felt, const est::Estimate<T>& estimate, safety::Rung rung,
                          core::Duration elapsed) {
  constexpr T kFar_m_s = T(0.5);
  tilt_check_.update(felt, core::seconds<T>(elapsed));
  cross_check_.update(felt, estimate, reckoning_.push_w_m_s2(), elapsed);
  const bool contradicted = contradiction().check != est::Check::kNone;
  const core::Vector<T, 2> apart =
      core::Vector<T, 2>(estimate.x.velocity_m_s, estimate.y.velocity_m_s) - reckoning_.velocity_w_m_s();
  const bool settles = rung == safety::Rung::kLevel || rung == safety::Rung::kRelease;
  const bool refused = settles && estimate.refused_poses > 0 && apart.squaredNorm() > kFar_m_s * kFar_m_s;
  lied_to_ = contradicted || refused || (lied_to_ && settles);
  const T speed_m_s = core::sqrt(reckoning_.velocity_w_m_s().squaredNorm());
  if (!lied_to_) {
    most_m_s_ = speed_m_s + static_cast<T>(kTurnsRound_s) * cross_check_.moved_m_s2() + static_cast<T>(kGust_m_s);
  }
  const bool runs_away = settles && speed_m_s > most_m_s_;
  tilt_lies_ = rates_contradict() || runs_away || (tilt_lies_ && settles);
  const bool trusted = !lied_to_ && !cross_check_.doubts() && estimate.refused_poses == 0;
  reckoning_.update(felt, estimate, cross_check_.felt_h_m_s2(), trusted, rung == safety::Rung::kSilent, elapsed);
}

template <typename T>
est::Estimate<T> PoseTrust<T>::motion(const est::Estimate<T>& estimate) const {
  constexpr T kNotToBeUsed_m2_s2 = T(1e6);
  est::Estimate<T> known = lied_to_ ? reckoning_.instead_of(estimate) : estimate;
  if (tilt_lies_) {
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
  if (!estimate.predicts || tilt_lies_ || !learned) {
    return 0.0;
  }
  const core::Vector<T, 2> velocity_m_s =
      lied_to_ ? reckoning_.velocity_w_m_s() : core::Vector<T, 2>(x.velocity_m_s, y.velocity_m_s);
  return static_cast<double>(core::sqrt(velocity_m_s.squaredNorm()));
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
