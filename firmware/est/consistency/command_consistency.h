// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/eigen.h"
#include "firmware/core/maths.h"
#include "firmware/est/estimate.h"

namespace m100::est {

/// Checks that the tilt reported by the autopilot responds to our own commands: the third source where poses and
/// attitude contradict each other. A rotor's force has no part along the body's horizontal axes, so a specific force
/// that is rotated by a false attitude is false too: force and attitude then agree with each other against the pose,
/// and these two alone cannot show which is wrong. The commands are ours; the vehicle file models the response to them.
///
///   w  the reported tilt, u the tilt that commands and model predict, each less its mean over half a second; e = w - u
///   the tilt does not respond if the mean of |e|^2 over a second exceeds that of |w|^2, plus the square of the error
///   that a correct model may leave, for kAlarm_s: subtracting the prediction then makes the tilt no smaller
///
/// Subtracting the mean removes the trim, and what the observer learns of it: the command follows that in seconds, and
/// the tilt does not change. A response with gain k and phase lag p passes if |1 - k exp(-i p)| < k: without lag any
/// gain above a half, with gain 1 any lag below 60 degrees. This check alone must not reject the attitude: a hand, a
/// tether or a load tilts the aircraft as well.
///
/// Seven numbers; no heap. Cost: about 20 products a tick. T is float or double.
template <typename T>
class CommandConsistency {
 public:
  using Vector2 = core::Vector<T, 2>;

  /// Once per tick, after the observer.
  /// @param model_tilt_rad tilt about both axes of the yaw-free frame, from commands and model
  /// @param ours the commands in force are ours
  void update(const Estimate<T>& estimate, const Vector2& model_tilt_rad, bool ours, T step_s);

  bool contradicts_command() const { return lasts_s_ > static_cast<T>(kAlarm_s); }
  /// Root mean square of e over a second, and its allowed value; rad.
  T residual_rad() const { return core::sqrt(residual_rad2_); }
  T allowed_rad() const { return core::sqrt(allowed_rad2()); }

 private:
  /// Residuals expected in roll and pitch (sysid::ResidualMonitor): twice those of the measured flights' models.
  static constexpr double kModelError_rad2 = 0.008 * 0.008 + 0.006 * 0.006;

  /// A response may be 80 ms later than its model predicts. After a command begins, the mean of |e|^2 then exceeds that
  /// of |w|^2 for twice that time.
  static constexpr double kAlarm_s = 0.2;

  T allowed_rad2() const { return reported_rad2_ + static_cast<T>(kModelError_rad2); }

  Vector2 mean_reported_rad_ = Vector2::Zero();
  Vector2 mean_model_rad_ = Vector2::Zero();
  T residual_rad2_{0};  ///< mean of |e|^2
  T reported_rad2_{0};  ///< mean of |w|^2
  T lasts_s_{0};        ///< how long residual_rad2_ has exceeded its allowed value
};

extern template class CommandConsistency<float>;
extern template class CommandConsistency<double>;

}  // namespace m100::est
