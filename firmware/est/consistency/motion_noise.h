// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/eigen.h"
#include "firmware/core/maths.h"
#include "firmware/est/consistency/specific_force.h"
#include "firmware/est/estimate.h"
#include "firmware/est/imu_sample.h"
#include "firmware/est/vibration.h"

namespace m100::est {

/// Estimates the white noise of the specific force (Vibration) and of the poses, whose is estimated from differences of
/// neighbouring samples. Slow changes do not add to it. PathConsistency widens its bounds by the noise beyond its
/// assumed values.
///
/// No heap. Cost: about 20 products a tick. T is float or double.
template <typename T>
class MotionNoise {
 public:
  using Vector3 = core::Vector<T, 3>;

  using Level = typename Vibration<T>::Level;  ///< mean squares

  /// Once per tick, after SpecificForce.
  /// @param pose_used a pose was used in this tick
  void update(const ImuSample<T>& imu, const SpecificForce<T>& force, const Estimate<T>& estimate, bool pose_used,
              T step_s);
  const Vibration<T>& vibration() const { return vibration_; }
  const Level& position_m2() const { return position_.level; }  ///< of the estimated path, by pose noise, per tick
  /// Variance of the observer's climb speed by the same noise.
  T climb_m2_s2() const { return T(2) * position_.level.vertical * climb_per_height_s_ * climb_per_height_s_; }
  T magnitude() const { return vibration_.magnitude() + position_.level.horizontal + position_.level.vertical; }
  void reset() {
    vibration_ = {};
    position_ = {};
  }

 private:
  struct Differences {
    Vector3 before = Vector3::Zero();
    Level level;
    void add(const Vector3& now, T weight, T vertical_weight, T share);
  };

  Vibration<T> vibration_;
  Differences position_;
  Vector3 position_w_m_ = Vector3::Zero();  ///< in the tick before
  T force_age_s_{0};
  T since_correction_s_{0};  ///< since the last correction by a pose
  T climb_per_height_s_{0};  ///< ratio of the two corrections by the newest pose; 1/s
};

extern template class MotionNoise<float>;
extern template class MotionNoise<double>;

}  // namespace m100::est
