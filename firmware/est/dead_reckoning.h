// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "firmware/core/eigen.h"
#include "firmware/core/time.h"
#include "firmware/est/estimate.h"
#include "firmware/est/felt.h"

namespace m100::est {

/// Horizontal motion as it is known beside the poses: what the aircraft brakes by where the poses are a lie. The
/// observer cannot serve: within half a second it has learned a false wind and a false speed from the lie.
///
///   v' = g tan(tilt) + p + (v_pose - v) / 4 s     tilt: the autopilot's attitude; v_pose: the observer's velocity
///   p  = median(d, f - g tan(tilt), q)            d: the observer's disturbance; f: the force that is felt
///   q' = (p - q) / 10 s                           the mean push of the flight until now
///
/// Three witnesses tell the push of the wind, and the middle one is believed: a pose that lies is outvoted by the force
/// and the past, a force that lies (a hand, a tether, a new offset) by the pose and the past, and a wind that turns is
/// seen by pose and force. What a lie tells of the velocity enters by a quarter of itself in a second, and no longer
/// enters at all once it is contradicted or refused; then an error of the push of 0.1 m/s^2 is 0.1 m/s after a second.
///
/// While the pilot flies, it stands: a pose that lies before control is taken has nobody to contradict its speed, and
/// who hands over hovers. A pose faster than 1 m/s is believed: then he does not.
///
/// Ten numbers; no heap. Cost: about 40 products a tick. T is float or double.
template <typename T>
class DeadReckoning {
 public:
  using Vector2 = core::Vector<T, 2>;

  /// Once per tick. @param felt_h_m_s2 as CrossCheck tells it; without it the past counts twice. @param trusted nothing
  /// contradicts the poses. @param pilots the pilot flies.
  void update(const Felt<T>& felt, const Estimate<T>& estimate, const std::optional<Vector2>& felt_h_m_s2, bool trusted,
              bool pilots, core::Duration elapsed);

  /// Another witness knows the velocity better.
  void believe(const Vector2& velocity_w_m_s) { velocity_w_m_s_ = velocity_w_m_s; }

  /// The estimate with its horizontal velocity, disturbance and input offset replaced by those that are known beside
  /// the poses. The position stays what it was: nothing but the poses tells it.
  Estimate<T> instead_of(const Estimate<T>& estimate) const;

  const Vector2& velocity_w_m_s() const { return velocity_w_m_s_; }
  const Vector2& push_w_m_s2() const { return push_w_m_s2_; }
  /// Of the input, mean; about both axes of the yaw-free frame.
  const Vector2& offset_rad() const { return offset_rad_; }

 private:
  T seen_s_{0};  ///< how long the push has been averaged; at most its memory
  Vector2 velocity_w_m_s_ = Vector2::Zero();
  Vector2 push_w_m_s2_ = Vector2::Zero();
  Vector2 offset_rad_ = Vector2::Zero();     ///< of the input, mean
  Vector2 slope_ = Vector2::Zero();          ///< of the newest attitude, in heading axes
  Vector2 tilted_h_m_s2_ = Vector2::Zero();  ///< what it accelerates by, averaged as the force is
};

extern template class DeadReckoning<float>;
extern template class DeadReckoning<double>;

}  // namespace m100::est
