// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/eigen.h"
#include "firmware/core/maths.h"
#include "firmware/est/estimate.h"

namespace m100::est {

/// Checks that the aircraft's tilt responds to our own commands. This decides between poses and attitude where the two
/// contradict each other: a false attitude falsifies the specific force as well. Hypothesis: the tilt does not respond.
///
///   w  the observer's tilt, which the reported attitude corrects
///   u  the tilt that the model predicts from the commands; of w and u the mean over half a second is subtracted
///   contradiction: mean of |w - u|^2 over a second > mean of |w|^2 + kModelError_rad2, for longer than kAlarm_s
///
/// Subtracting the mean removes the trim. A response with gain k and phase lag p passes if |1 - k exp(-i p)| < k. This
/// check alone must not reject the attitude: a hand, a tether or a load tilts the aircraft as well.
///
/// Seven numbers; no heap. Cost: about 20 products a tick. T is float or double.
template <typename T>
class CommandConsistency {
 public:
  using Vector2 = core::Vector<T, 2>;

  /// Once per tick, after the observer.
  /// @param model_tilt_rad tilt about both axes of the yaw-free frame, from commands and model
  /// @param ours the commands in force are ours; otherwise the check starts again
  void update(const Estimate<T>& estimate, const Vector2& model_tilt_rad, bool ours, T step_s);

  bool contradicts_command() const { return lasts_s_ > static_cast<T>(kAlarm_s); }
  /// Root mean square of w - u over a second, and its allowed value; rad.
  T residual_rad() const { return core::sqrt(residual_rad2_); }
  T allowed_rad() const { return core::sqrt(allowed_rad2()); }

 private:
  /// Mean square of |w - u| that a correct model may leave: 8 mrad rms in one axis and 6 mrad in the other, twice the
  /// residuals of the measured flights.
  static constexpr double kModelError_rad2 = 0.008 * 0.008 + 0.006 * 0.006;

  /// A response may be 80 ms later than its model. After a command begins, the mean of |w - u|^2 then exceeds that of
  /// |w|^2 for twice that time.
  static constexpr double kAlarm_s = 0.2;

  T allowed_rad2() const { return reported_rad2_ + static_cast<T>(kModelError_rad2); }

  Vector2 mean_reported_rad_ = Vector2::Zero();
  Vector2 mean_model_rad_ = Vector2::Zero();
  T residual_rad2_{0};  ///< mean of |w - u|^2
  T reported_rad2_{0};  ///< mean of |w|^2
  T lasts_s_{0};        ///< how long residual_rad2_ has exceeded its allowed value
};

extern template class CommandConsistency<float>;
extern template class CommandConsistency<double>;

}  // namespace m100::est
