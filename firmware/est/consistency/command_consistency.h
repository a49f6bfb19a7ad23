// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/eigen.h"
#include "firmware/core/maths.h"

namespace m100::est {

/// Decides between poses and attitude where the two contradict each other, by the tilt that our own commands give: a
/// false attitude falsifies the specific force as well. Of three hypotheses the likeliest holds.
///
///   p  velocity by the poses (ModelVelocity) less that by attitude and force (DeadReckoning): their contradiction
///   c  integral of g (tan u - tan w);  u: tilt that the model predicts from the commands, w: reported tilt
///   poses false:     the aircraft tilts as it is told, c is the model's error; misfit |c|^2
///   not answered:    a hand, a tether or a load tilts it, and p is only the lag of ModelVelocity behind the poses,
///                    n, the integral that c is, but over kLag_s; misfit |p - n|^2
///   attitude false:  c equals p; misfit |p - c|^2
///
/// The commands contradict the attitude while its misfit has been the smallest for longer than kAlarm_s, and half of p
/// is more than the error of c: kModelError_rad over kMemory_s, and kGainError of all commanded changes of velocity.
/// All velocities are changes over about kMemory_s.
///
/// Thirteen numbers; no heap. Cost: about 30 products and two square roots a tick. T is float or double.
template <typename T>
class CommandConsistency {
 public:
  using Vector2 = core::Vector<T, 2>;

  /// Accelerations in the world, by the tilt and the wind; m/s^2.
  struct Tilted {
    Vector2 commanded_m_s2 = Vector2::Zero();  ///< by the tilt that the model predicts
    Vector2 reported_m_s2 = Vector2::Zero();   ///< by the tilt that the autopilot reports
  };

  /// Once per tick, after the observer.
  /// @param apart_m_s velocity by the poses less the dead-reckoned one
  /// @param poses_come otherwise the first is only that of the commands
  /// @param ours the commands in force are ours; otherwise the check starts again
  void update(const Vector2& apart_m_s, const Tilted& tilted, bool poses_come, bool ours, T step_s);

  bool contradicts_command() const { return lasts_s_ > static_cast<T>(kAlarm_s); }
  /// Mean difference between reported and predicted tilt over kMemory_s, and the model's error; rad.
  T residual_rad() const { return residual_rad_; }
  T allowed_rad() const { return allowed_rad_; }

 private:
  /// A correct model leaves 4 mrad rms in one axis and 3 mrad in the other (measured flights).
  static constexpr double kModelError_rad = 0.005;
  static constexpr double kGainError = 0.1;  ///< half of the 20 % by which the aircraft's gain may differ
  /// A response may be 80 ms later than its model. After a command begins, c is wrong for twice that time.
  static constexpr double kAlarm_s = 0.2;

  Vector2 mean_apart_m_s_ = Vector2::Zero();
  Vector2 unreported_m_s_ = Vector2::Zero();        ///< c
  Vector2 lag_m_s_ = Vector2::Zero();               ///< n
  Vector2 mean_without_lag_m_s_ = Vector2::Zero();  ///< of p - n
  T commanded_m_s_{0};                              ///< sum of all commanded changes of velocity
  T residual_rad_{0};
  T allowed_rad_{0};
  T lasts_s_{0};  ///< how long the attitude has been the likeliest
};

extern template class CommandConsistency<float>;
extern template class CommandConsistency<double>;

}  // namespace m100::est
