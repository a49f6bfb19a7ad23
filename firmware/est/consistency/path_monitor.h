// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/eigen.h"
#include "firmware/core/time.h"
#include "firmware/est/consistency/force_consistency.h"
#include "firmware/est/consistency/motion_noise.h"
#include "firmware/est/consistency/path_consistency.h"
#include "firmware/est/consistency/specific_force.h"
#include "firmware/est/estimate.h"
#include "firmware/est/imu_sample.h"
#include "firmware/est/lever_arm_fit.h"

namespace m100::est {

/// Compares the horizontal path and the height of the poses with those of the specific force (PathConsistency). The two
/// comparisons take turns, one per tick. After a second without a pose both restart.
///
/// No heap. T is float or double.
template <typename T>
class PathMonitor {
 public:
  using Vector2 = core::Vector<T, 2>;
  /// Without a used pose for this long, the observer's motion is its own prediction.
  static constexpr core::Duration kPoseUsed = std::chrono::milliseconds(300);

  /// Once per tick, before the force is compared.
  /// @returns whether the observer's velocity is its own prediction, or the first poses after a gap still correct it
  bool recovers_from_gap(const Estimate<T>& estimate, T step_s);
  /// Once per tick, after ForceConsistency has compared the same force. It starts once the sensor's error has been
  /// learned for a second.
  /// @param disabled the operator has switched the check, or that of the force, off
  /// @returns whether the paths were compared
  bool update(const ImuSample<T>& imu, const Estimate<T>& estimate, const SpecificForce<T>& force,
              const ForceConsistency<T>& velocity, bool disabled, T step_s);
  void restart() {
    lever_arm_.restart();
    horizontal_.restart();
    vertical_.restart();
  }

  /// The larger evidence of the two, as a share of the threshold from which it contradicts the poses.
  T evidence() const { return vertical_is_worse() ? vertical_.evidence() : horizontal_.evidence(); }
  T residual_m() const { return vertical_is_worse() ? vertical_.residual_m() : horizontal_.residual_m(); }
  T allowed_m() const { return vertical_is_worse() ? vertical_.allowed_m() : horizontal_.allowed_m(); }
  /// Bound of the observer's error of the climb speed in a climb: the vehicle file's gain is not exact (kClimbGain).
  T climb_error_m_s() const { return climb_error_m_s_; }
  T climb_noise_m2_s2() const { return noise_.climb_m2_s2(); }
  const Vibration<T>& vibration() const { return noise_.vibration(); }
  const LeverArmFit<T>& lever_arm() const { return lever_arm_; }
  T magnitude() const {
    return noise_.magnitude() + jolt_m_s_ + climb_error_m_s_ + mean_tilt_acceleration_h_m_s2_.squaredNorm();
  }
  void reset();

 private:
  bool vertical_is_worse() const { return horizontal_.evidence() < vertical_.evidence(); }
  void update_climb_error(const ImuSample<T>& imu, const Estimate<T>& estimate, T step_s);
  void update_jolt(const ImuSample<T>& imu, const SpecificForce<T>& force, T step_s);
  void update_horizontal(const Estimate<T>& estimate, const ForceConsistency<T>& velocity, const Vector2& force_w_m_s2,
                         T turn_rad_s, bool pose_used, T step_s);
  void update_vertical(const Estimate<T>& estimate, const SpecificForce<T>& force, T vertical_acceleration_m_s2,
                       bool pose_used, T step_s);

  PathConsistency<T> horizontal_;
  PathConsistency<T, 1> vertical_;
  LeverArmFit<T> lever_arm_;
  MotionNoise<T> noise_;
  bool vertical_turn_ = false;                     ///< this tick compares the height, the next one the horizontal path
  Vector2 force_before_w_m_s2_ = Vector2::Zero();  ///< in the tick before
  T vertical_before_m_s2_{0};
  Vector2 mean_tilt_acceleration_h_m_s2_ = Vector2::Zero();  ///< over a second
  T measured_climb_m_s_{0};                                  ///< newest climb speed of the autopilot
  T measured_gain_m_s_{0};  ///< change of climb speed since measured_climb_m_s_ came, by the force
  T jolt_m_s_{0};           ///< largest change that the force missed, since the height was compared
  T climb_error_m_s_{0};
  T gap_recovery_s_{0};  ///< for how long poses still correct what the observer predicted without them
  T last_age_s_{0};
  T unused_s_{0};  ///< since a pose was used
};

extern template class PathMonitor<float>;
extern template class PathMonitor<double>;

}  // namespace m100::est
