// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/eigen.h"
#include "firmware/core/maths.h"

namespace m100::est {

/// Horizontal velocity from the commanded tilt and the poses, without any measured attitude. It serves flights whose
/// attitude is contradicted or does not come.
///
/// Critically damped alpha-beta filter (fading memory) around the model's acceleration a:
///   each tick  v += a h, p += v h
///   each pose  e = pose - (p - v age), x = min(w t, 1/2):  p += x (2 - x) e, v += x^2 / t e
/// where t is the time since the pose before and w = 8 1/s. An acceleration that is wrong by b leaves a velocity error
/// of 2 b / w.
///
/// Five numbers; no heap. Cost: about 15 products a tick. T is float or double.
template <typename T>
class ModelVelocity {
 public:
  using Vector2 = core::Vector<T, 2>;
  static constexpr double kBandwidth_per_s = 8.0;
  static constexpr double kLag_s = 2.0 / kBandwidth_per_s;  ///< velocity error per wrong acceleration

  /// Once per tick, before the pose of that tick. @param acceleration_w_m_s2 from the commanded tilt and the wind
  void predict(const Vector2& acceleration_w_m_s2, T step_s) {
    since_pose_s_ = core::clamp(since_pose_s_ + step_s, step_s, static_cast<T>(kUnknown_s));
    velocity_w_m_s_ += acceleration_w_m_s2 * step_s;
    position_w_m_ += velocity_w_m_s_ * step_s;
  }
  /// @param age_s of the pose
  void fuse(const Vector2& position_w_m, T age_s) {
    const Vector2 error_m = position_w_m - position_w_m_ + velocity_w_m_s_ * age_s;
    const bool follows = is_known() && error_m.squaredNorm() < static_cast<T>(kFar_m * kFar_m);  // false if not finite
    if (follows) {
      const T share = core::clamp(static_cast<T>(kBandwidth_per_s) * since_pose_s_, T(0), T(0.5));
      position_w_m_ += error_m * (share * (T(2) - share));
      velocity_w_m_s_ += error_m * (share * share / since_pose_s_);
    } else {
      position_w_m_ = position_w_m;
      velocity_w_m_s_.setZero();
    }
    since_pose_s_ = T(0);
  }

  /// Whether a pose came in the last kUnknown_s.
  bool is_known() const { return since_pose_s_ < static_cast<T>(kUnknown_s); }
  /// Whether poses come, so that the velocity is theirs and not only that of the commands.
  bool follows_poses() const { return since_pose_s_ * static_cast<T>(kBandwidth_per_s) < T(1); }
  const Vector2& velocity_w_m_s() const { return velocity_w_m_s_; }

 private:
  static constexpr double kFar_m = 1.0;      ///< a pose that is farther away restarts the filter there, at rest
  static constexpr double kUnknown_s = 2.0;  ///< in this time a trim that is wrong by half a degree adds 0.2 m/s

  T since_pose_s_ = static_cast<T>(kUnknown_s);
  Vector2 position_w_m_ = Vector2::Zero();
  Vector2 velocity_w_m_s_ = Vector2::Zero();
};

}  // namespace m100::est
