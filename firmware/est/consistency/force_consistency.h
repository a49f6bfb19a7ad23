// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/eigen.h"
#include "firmware/core/maths.h"
#include "firmware/est/consistency/cusum.h"
#include "firmware/est/consistency/specific_force.h"
#include "firmware/est/estimate.h"
#include "firmware/est/vibration.h"

namespace m100::est {

/// Compares the horizontal velocity of the poses, as the observer estimates it, with the specific force.
///
/// Hypothesis: the poses' velocity changes and the force does not show it, or the other way round.
/// Statistic: the change of velocity of about the last two seconds that the force does not show,
///   g' = v_pose' - (f + o) - g / 2 s      f + o: SpecificForce
/// Allowed is the sum of
///   calm   0.1 m/s: three sigmas of the observer's velocity in calm air
///   moves  0.08 s times the largest acceleration of the last second, because the time of capture may be wrong by 80 ms
///   wind   0.05 s times the acceleration by wind
///   swing  0.15 s times the disturbance that the force shows and the observer has not learned yet
/// but at most 0.35 m/s. Three sigmas of what the measured vibration adds to the sum, beyond the part that calm
/// includes, are added. Three times start_sigma_m_s() is added and, until kFirstLook_s, the unknown error of the
/// sensor. False alarms: an alarm takes half a second at twice the allowed value, which is six sigmas in calm air.
/// Smallest fault detected in 3 s of calm hover: a false acceleration of 0.13 m/s^2.
///
/// No heap. Cost: six square roots and about 60 products a tick, SpecificForce included. T is float or double.
template <typename T>
class ForceConsistency {
 public:
  using Vector2 = core::Vector<T, 2>;

  /// Once per tick, after the observer. Lets `force` learn its sensor's error.
  /// @param suspect force or path disagreed with the poses in the tick before
  /// @param wind_w_m_s2 acceleration by wind (world), from DeadReckoning
  void update(const Estimate<T>& estimate, SpecificForce<T>& force, const Vibration<T>& vibration,
              const Vector2& wind_w_m_s2, bool suspect, T step_s);
  /// Continues the sum from the next velocity. Call it when the motion was not observed.
  void restart() { velocity_known_ = false; }
  /// The observer has lost its estimate: start_sigma_m_s() returns to its largest value.
  void lose_estimate() { start_sigma_m_s_ = T(10); }

  bool exceeds_allowed() const { return evidence_.residual > evidence_.allowed; }
  CheckEvidence<T>& evidence() { return evidence_; }
  /// Smallest sigma of the velocity since lose_estimate(), minus the sigma in calm air; m/s. reset() keeps it.
  T start_sigma_m_s() const { return start_sigma_m_s_; }
  /// The observer's horizontal velocity in the newest tick.
  const Vector2& velocity_w_m_s() const { return velocity_w_m_s_; }
  T magnitude() const { return residual_w_m_s_.squaredNorm(); }
  void reset();

  /// Nothing is summed before SpecificForce::learned_s() reaches this: the observer settles after its start.
  static constexpr double kBegins_s = 1.0;
  /// Until learned_s() reaches this, the sensor's error is not well known: its uncertainty is allowed in addition.
  static constexpr double kFirstLook_s = 3.0;
  /// Memory of the sum. It bounds what an unknown error of the sensor adds to the sum. White noise of the density S
  /// adds the variance S kVelocityMemory_s / 2 to each axis.
  static constexpr double kVelocityMemory_s = 2.0;

 private:
  T residual_m_s(const Estimate<T>& estimate, SpecificForce<T>& force, bool suspect, T step_s);
  void update_start_sigma(const Estimate<T>& estimate);
  void update_learned_push(const SpecificForce<T>& force, T step_s);
  T allowed_m_s(const SpecificForce<T>& force, const Vibration<T>& vibration, const Vector2& wind_w_m_s2) const;

  bool velocity_known_ = false;
  T start_sigma_m_s_{10};
  Vector2 velocity_w_m_s_ = Vector2::Zero();
  T climb_m_s_{0};
  Vector2 residual_w_m_s_ = Vector2::Zero();
  T summed_s_{0};  ///< time over which residual_w_m_s_ is summed, with the same memory
  /// The measured disturbance: the part that the observer may have learned, and the rest; forward and left.
  Vector2 learned_push_h_m_s2_ = Vector2::Zero();
  Vector2 new_push_h_m_s2_ = Vector2::Zero();
  CheckEvidence<T> evidence_;
};

extern template class ForceConsistency<float>;
extern template class ForceConsistency<double>;

}  // namespace m100::est
