// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/est/consistency/force_consistency.h"

#include "firmware/core/frames.h"

namespace m100::est {
namespace {

constexpr double kMaxAllowed_m_s = 0.35;
constexpr double kFirstLook_m_s = 0.15;
constexpr double kCalm_m_s = 0.1, kMoves_s = 0.08, kWind_s = 0.05, kSigmas = 3.0;
constexpr double kLearns_s = 0.15;  // time in which the observer learns a disturbance from poses (disturbance_ekf.cpp)
/// Density of the noise that kCalm_m_s includes: the rotors' 0.1 m/s^2 at 100 Hz, and half as much again, because it is
/// measured from few messages.
constexpr double kAssumed_m2_s3 = 1.5e-4;
constexpr double kMaxStartSigma_m_s = 10.0;

}  // namespace

/// @returns the difference between the changes of horizontal velocity by pose and by force over about the last 2 s
template <typename T>
T ForceConsistency<T>::residual_m_s(const Estimate<T>& estimate, SpecificForce<T>& force, bool suspect, T step_s) {
  const core::SinCos<T>& yaw = estimate.heading();
  const Vector2 velocity(estimate.x.velocity_m_s, estimate.y.velocity_m_s);
  const Vector2 step_w = velocity - velocity_w_m_s_;
  velocity_w_m_s_ = velocity;
  const T climbed_m_s = estimate.climb_m_s - climb_m_s_;
  climb_m_s_ = estimate.climb_m_s;
  if (!force.is_received() || !velocity_known_) {
    velocity_known_ = true;
    return T(0);
  }
  const Vector2 step_h = core::rotate<T>(step_w, {.sine = -yaw.sine, .cosine = yaw.cosine});
  const typename SpecificForce<T>::Unmeasured unmeasured = force.learn(step_h, climbed_m_s, suspect, step_s);
  if (force.learned_s() < static_cast<T>(kBegins_s)) {
    residual_w_m_s_.setZero();
    summed_s_ = T(0);
    return T(0);
  }
  // The sum uses the error as it is known now, not as it was known while the sum was accumulated.
  const T fades = step_s * static_cast<T>(1.0 / kVelocityMemory_s);
  summed_s_ += step_s - summed_s_ * fades;
  residual_w_m_s_ +=
      core::rotate<T>(unmeasured.change_h_m_s - unmeasured.learned_h_m_s * (suspect ? T(0) : summed_s_), yaw) -
      residual_w_m_s_ * fades;
  return core::sqrt(residual_w_m_s_.squaredNorm());
}

/// Updates the smallest sigma of the velocity since the start: a start in wind leaves the observer uncertain for some
/// seconds. A later rise is ignored, because a sensor fault may cause it.
template <typename T>
void ForceConsistency<T>::update_start_sigma(const Estimate<T>& estimate) {
  const T variance_m2_s2 = core::clamp(estimate.x.velocity_variance_m2_s2 + estimate.y.velocity_variance_m2_s2, T(0),
                                       static_cast<T>(kMaxStartSigma_m_s * kMaxStartSigma_m_s));
  const T sigma_m_s = core::sqrt(variance_m2_s2) - static_cast<T>(kCalm_m_s / kSigmas);
  start_sigma_m_s_ = core::clamp(sigma_m_s, T(0), start_sigma_m_s_);
}

template <typename T>
void ForceConsistency<T>::update_learned_push(const SpecificForce<T>& force, T step_s) {
  new_push_h_m_s2_ = force.acceleration_h_m_s2() - force.tilt_acceleration_h_m_s2() - learned_push_h_m_s2_;
  learned_push_h_m_s2_ += new_push_h_m_s2_ * (step_s * static_cast<T>(1.0 / kLearns_s));
}

template <typename T>
T ForceConsistency<T>::allowed_m_s(const SpecificForce<T>& force, const Vibration<T>& vibration,
                                   const Vector2& wind_w_m_s2) const {
  const T wind_m_s2 = core::sqrt(wind_w_m_s2.squaredNorm());
  const T allowed = static_cast<T>(kCalm_m_s) + static_cast<T>(kMoves_s) * force.moved_m_s2() +
                    static_cast<T>(kWind_s) * wind_m_s2 +
                    static_cast<T>(kLearns_s) * core::sqrt(new_push_h_m_s2_.squaredNorm());
  const T most = static_cast<T>(kMaxAllowed_m_s);
  const T unknown =
      core::clamp((static_cast<T>(kFirstLook_s) - force.learned_s()) * static_cast<T>(1.0 / (kFirstLook_s - kBegins_s)),
                  T(0), T(1));
  const T variance_m2_s2 = (vibration.density_m2_s3().horizontal - static_cast<T>(kAssumed_m2_s3)) *
                           static_cast<T>(kVelocityMemory_s);  // of both axes
  return (allowed < most ? allowed : most) + static_cast<T>(kSigmas) * core::sqrt(variance_m2_s2) +
         unknown * static_cast<T>(kFirstLook_m_s) + static_cast<T>(kSigmas) * start_sigma_m_s_;
}

template <typename T>
void ForceConsistency<T>::update(const Estimate<T>& estimate, SpecificForce<T>& force, const Vibration<T>& vibration,
                                 const Vector2& wind_w_m_s2, bool suspect, T step_s) {
  evidence_.residual = residual_m_s(estimate, force, suspect, step_s);
  update_start_sigma(estimate);
  update_learned_push(force, step_s);
  evidence_.allowed = allowed_m_s(force, vibration, wind_w_m_s2);
}

template <typename T>
[[gnu::cold]] void ForceConsistency<T>::reset() {
  residual_w_m_s_.setZero();
  learned_push_h_m_s2_.setZero();
  new_push_h_m_s2_.setZero();
  summed_s_ = T(0);
  velocity_known_ = false;
}

template class ForceConsistency<float>;
template class ForceConsistency<double>;

}  // namespace m100::est
