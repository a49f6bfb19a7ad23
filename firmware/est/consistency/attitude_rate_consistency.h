// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/eigen.h"
#include "firmware/est/consistency/cusum.h"
#include "firmware/est/imu_sample.h"

namespace m100::est {

/// Compares the autopilot's attitude with the autopilot's body rates. It needs no pose. Hypothesis: the attitude
/// does not turn as the rates say.
///
///   e' = tilt' - (tilt rate from the body rates) - e / 0.25 s     roll and pitch together
///
/// The ratio of |e| to its allowed value is summed (Cusum). The check finds a tilt that does not move, or whose units
/// or axes differ from those of the rates. It finds nothing if both are wrong in the same way.
///
/// Changes of the tilt beyond every recent rate (jumps) are summed separately. The larger of the two residuals, each
/// relative to its allowed value, is used.
///
/// Sixteen numbers; no heap. Cost: three to six square roots and about 50 products an attitude, plus the shared sines
/// and cosines of its angles. T is float or double.
template <typename T>
class AttitudeRateConsistency {
 public:
  /// Once per tick.
  void update(const ImuSample<T>& imu, T step_s);

  /// Attitude and rates contradict each other.
  bool contradicts() const { return cusum_.exceeds_threshold(); }
  /// The difference of attitude and rates that the check uses, and its allowed value; rad.
  T residual_rad() const { return residual_rad_; }
  T allowed_rad() const { return allowed_rad_; }

 private:
  using Vector2 = core::Vector<T, 2>;

  void add_jump(const Vector2& unturned_rad, T fastest2, T passed_s);
  void weigh(T passed_s);

  T age_s_{1};                                 ///< since the newest attitude came
  Vector2 tilt_rad_ = Vector2::Zero();         ///< roll and pitch of the newest attitude
  Vector2 tilt_rate_rad_s_ = Vector2::Zero();  ///< their rates of change, from the body rates
  Vector2 unturned_rad_ = Vector2::Zero();     ///< change of tilt that the rates do not explain, leaky sum
  Vector2 turned_rad_ = Vector2::Zero();       ///< change of tilt that the rates imply, leaky sum
  Vector2 jumped_rad_ = Vector2::Zero();       ///< change of tilt that no recent rate explains, leaky sum
  T fastest_rad_s_{0};                         ///< largest recent rate that attitude and rates both show
  T farthest_rad_{0};                          ///< largest recent turn that attitude and rates both show
  Cusum<T> cusum_;
  T residual_rad_{0};
  T allowed_rad_{0};
};

extern template class AttitudeRateConsistency<float>;
extern template class AttitudeRateConsistency<double>;

}  // namespace m100::est
