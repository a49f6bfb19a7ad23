// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "firmware/core/eigen.h"
#include "firmware/core/time.h"
#include "firmware/est/estimate.h"
#include "firmware/est/imu_sample.h"

namespace m100::est {

/// Horizontal motion and heading by which the aircraft brakes when the poses are contradicted. The observer cannot
/// serve for that: within half a second faulty poses give it a false wind, speed and heading.
///
///   v' = g tan(tilt) + p + (v_pose - v) / 4 s     tilt: the autopilot's; v_pose: the observer's velocity
///   h' = gyro + (h_pose - h) / 4 s                h: the heading, which turns the tilt into the world
///   p  = median(d, f - g tan(tilt), q)            d: the observer's disturbance; f: the measured force
///   q' = (p - q) / 10 s                           the mean of p over the last 10 s or less
///
/// p is the acceleration by the wind. The median outvotes one source that is wrong. v and h approach those of the
/// observer, and q learns, only while the poses are trusted.
///
/// While the pilot flies and the poses are slower than 1 m/s, v decays to zero instead. After a gap of more than 50 ms
/// in the attitude or the ticks, v and h continue from the observer's, if the poses are trusted.
///
/// Thirteen numbers; no heap. Cost: about 40 products and one sine and cosine a tick. T is float or double.
template <typename T>
class DeadReckoning {
 public:
  using Vector2 = core::Vector<T, 2>;

  /// Once per tick.
  /// @param measured_h_m_s2 f, from VelocityConsistency; nullopt: q replaces f - g tan(tilt)
  /// @param trusted the poses are not suspected, contradicted or refused; only then v and q learn from them
  /// @param pilots the pilot flies
  void update(const ImuSample<T>& imu, const Estimate<T>& estimate, const std::optional<Vector2>& measured_h_m_s2,
              bool trusted, bool pilots, core::Duration elapsed);

  /// Subtracts what the sticks' neutrals took over from the estimated input offset.
  void subtract_input_offset(const Vector2& rad) { offset_rad_ -= rad; }
  /// Replaces the velocity by that of a better source.
  void set_velocity(const Vector2& velocity_w_m_s) { velocity_w_m_s_ = velocity_w_m_s; }

  /// The estimate with its horizontal velocity, disturbance, input offset and heading replaced by those of dead
  /// reckoning, its tilt turned by the difference of the headings, and a fixed variance of the velocity. The position
  /// is unchanged: only the poses determine it.
  Estimate<T> replace_motion(const Estimate<T>& estimate) const;

  const Vector2& velocity_w_m_s() const { return velocity_w_m_s_; }
  const Vector2& disturbance_acceleration_w_m_s2() const { return disturbance_acceleration_w_m_s2_; }
  /// Mean offset of the input, about both axes of the yaw-free frame.
  const Vector2& offset_rad() const { return offset_rad_; }

 private:
  void begin_if_due(const Estimate<T>& estimate, bool pilots);

  T seen_s_{0};          ///< how long the motion has been estimated; at most 10 s, the memory of q
  T attitude_age_s_{0};  ///< at most one second
  T heading_rad_{0};
  Vector2 velocity_w_m_s_ = Vector2::Zero();
  Vector2 disturbance_acceleration_w_m_s2_ = Vector2::Zero();
  Vector2 offset_rad_ = Vector2::Zero();                ///< mean, of the input
  Vector2 slope_ = Vector2::Zero();                     ///< of the newest attitude, in heading axes
  Vector2 tilt_acceleration_h_m_s2_ = Vector2::Zero();  ///< acceleration by that slope, averaged like the force
};

extern template class DeadReckoning<float>;
extern template class DeadReckoning<double>;

}  // namespace m100::est
