// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/eigen.h"
#include "firmware/core/maths.h"
#include "firmware/est/estimate.h"

namespace m100::est {

/// Whether the tilt that the autopilot tells is the one that our own commands ask for: the third witness where poses
/// and attitude contradict each other. A rotor's force has no part along the body's horizontal axes, so that a specific
/// force that is turned by an attitude that lies, lies with it: force and attitude stand together against the pose, and
/// by them alone nobody knows which side is wrong. The commands are ours, and the model of the answer is the vehicle
/// file's.
///
///   w  the tilt that is told, u the one that commands and model make, each less its mean over half a second; e = w - u
///   the tilt does not answer where the mean of |e|^2 over a second exceeds that of |w|^2 by the square of what a right
///   model may leave, for kLasts_s: the command then explains less than nothing of it
///
/// The mean takes the trim away, and what the observer learns of it: the command follows that in seconds, and the tilt
/// stays. An answer that is k times as large and late by t at w rad/s passes as long as |1 - k exp(-i w t)| < k: any
/// gain above a half, any delay below 60 degrees of the swing. Of one witness too few to accuse by itself: a hand, a
/// tether or a load tilts the aircraft as well.
///
/// Seven numbers; no heap. Cost: about 20 products a tick. T is float or double.
template <typename T>
class AnswerCheck {
 public:
  using Vector2 = core::Vector<T, 2>;

  /// Once per tick, after the observer.
  /// @param asked_rad tilt about both axes of the yaw-free frame, by command and model
  /// @param ours the commands in force are ours
  void update(const Estimate<T>& estimate, const Vector2& asked_rad, bool ours, T step_s);

  bool is_unanswered() const { return lasts_s_ > static_cast<T>(kLasts_s); }
  /// How far the tilt is from what is asked, and how far it may be; rad.
  T apart_rad() const { return core::sqrt(apart_rad2_); }
  T allowed_rad() const { return core::sqrt(allowed_rad2()); }

 private:
  /// Twice what the models of the measured flights leave of roll and pitch (sysid::ResidualMonitor), 0.008 and 0.006
  /// rad.
  static constexpr double kLeft_rad2 = 0.008 * 0.008 + 0.006 * 0.006;

  /// A command that begins leads an answer that is 80 ms later than its model, the most of the worlds that ship: until
  /// the answer outweighs what was missing of it, twice that passes.
  static constexpr double kLasts_s = 0.2;

  T allowed_rad2() const { return told_rad2_ + static_cast<T>(kLeft_rad2); }

  Vector2 mean_told_rad_ = Vector2::Zero();
  Vector2 mean_asked_rad_ = Vector2::Zero();
  T apart_rad2_{0};  ///< mean of |e|^2
  T told_rad2_{0};   ///< mean of |w|^2
  T lasts_s_{0};     ///< how long the first has exceeded what is allowed
};

extern template class AnswerCheck<float>;
extern template class AnswerCheck<double>;

}  // namespace m100::est
