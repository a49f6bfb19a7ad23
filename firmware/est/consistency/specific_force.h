// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/eigen.h"
#include "firmware/core/maths.h"
#include "firmware/core/tilt.h"
#include "firmware/est/imu_sample.h"
#include "firmware/model/vehicle.h"

namespace m100::est {

/// The autopilot's specific force f in axes at the aircraft's heading (forward, left, up). Also the correction o of the
/// sensor's constant error, which is learned over 20 s from the motion of the poses.
///
/// The unit is found from the length of the mean force, which vibration leaves: about 1 is g, about 9.8 is m/s^2.
/// Otherwise the force is not used.
///
/// No heap. Cost: two square roots and about 50 products a tick. T is float or double.
template <typename T>
class SpecificForce {
 public:
  using Vector2 = core::Vector<T, 2>;

  /// Takes a new message of the autopilot.
  void update(const ImuSample<T>& imu);

  /// Change of the poses' velocity in one tick that the force did not show, and the part of it that was learned as the
  /// sensor's error; m/s, forward and left.
  struct Unmeasured {
    Vector2 change_h_m_s = Vector2::Zero();
    Vector2 learned_h_m_s = Vector2::Zero();
  };
  /// Learns the sensor's error from one tick of motion, and averages the measured acceleration.
  /// @param change_h_m_s, climbed_m_s change of the velocity of the poses in the tick
  /// @param suspect force and poses disagree: only a small part is learned, the rest may be the effect of a fault
  Unmeasured learn(const Vector2& change_h_m_s, T climbed_m_s, bool suspect, T step_s);
  /// Averages the measured acceleration. learn() calls it; call it alone in a tick without a velocity of the poses.
  void average(const Vector2& acceleration_h_m_s2, T step_s);

  /// The acceleration that the force shows, without gravity and without the sensor's error.
  Vector2 acceleration_h_m_s2() const { return force_h_m_s2_ + bias_h_m_s2(); }
  T vertical_acceleration_m_s2() const {
    const T across_m_s2 = offset_h_m_s2_.dot(tilt_acceleration_h_m_s2_) * static_cast<T>(1.0 / model::kGravity_m_s2);
    return lifted_m_s2_ + offset_up_m_s2_ - across_m_s2;
  }
  /// The acceleration that the tilt alone makes.
  const Vector2& tilt_acceleration_h_m_s2() const { return tilt_acceleration_h_m_s2_; }
  /// The newest force with the sensor's error: forward, left, and upward without gravity.
  core::Vector<T, 3> raw_m_s2() const { return {force_h_m_s2_.x(), force_h_m_s2_.y(), lifted_m_s2_}; }
  /// acceleration_h_m_s2() averaged over kForceMean_s.
  const Vector2& mean_h_m_s2() const { return mean_h_m_s2_; }
  /// The largest recent magnitude of mean_h_m_s2(), fading over a second.
  T moved_m_s2() const { return moved_m_s2_; }
  /// Unit of the newest force in m/s^2; zero if it is not known or the force contains no gravity.
  T scale_m_s2() const { return scale_m_s2_; }
  /// Whether a finite force within a sensor's range has come since the start or the last reset(), in whatever unit.
  bool is_received() const { return !mean_b_.isZero(T(0)); }
  /// For how long the error has been learned; at most its memory, 20 s.
  T learned_s() const { return learned_s_; }

  /// Sum of the magnitudes of the learned and averaged values: not finite if one of them is not.
  T magnitude() const;
  void reset();

 private:
  Vector2 bias_h_m_s2() const {
    return offset_h_m_s2_ + tilt_acceleration_h_m_s2_ * (offset_up_m_s2_ * static_cast<T>(1.0 / model::kGravity_m_s2));
  }

  T scale_m_s2_{0};
  T learned_s_{0};
  core::Vector<T, 3> mean_b_ = core::Vector<T, 3>::Zero();  ///< as sent
  Vector2 force_h_m_s2_ = Vector2::Zero();                  ///< newest
  T lifted_m_s2_{0};                                        ///< newest upward, without gravity
  Vector2 tilt_acceleration_h_m_s2_ = Vector2::Zero();      ///< at the same time
  Vector2 offset_h_m_s2_ = Vector2::Zero();                 ///< correction of the sensor: body x and y
  T offset_up_m_s2_{0};                                     ///< correction of the sensor: body z
  Vector2 mean_h_m_s2_ = Vector2::Zero();
  T moved_m_s2_{0};
};

extern template class SpecificForce<float>;
extern template class SpecificForce<double>;

}  // namespace m100::est
