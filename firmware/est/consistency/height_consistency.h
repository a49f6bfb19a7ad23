// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/maths.h"
#include "firmware/est/consistency/cusum.h"
#include "firmware/est/estimate.h"
#include "firmware/est/imu_sample.h"

namespace m100::est {

/// Compares the height of the poses with the autopilot's height and climb speed, since control was taken.
///
/// Hypothesis: the pose's height drifts. Statistic d, from two differences of the changes since the start:
///   h = pose height - autopilot's height        c = pose height - integral of the autopilot's climb speed
/// d is the mean of h and c if they have the same sign and neither is more than twice the other, otherwise zero: an
/// error of only one channel of the autopilot contradicts nothing. Allowed: kHeightWander_m for the first 30 s, then
/// kHeightWander_m sqrt(t / 30 s), as the wander of a barometer grows.
/// False alarms: none in the measured logs, whose largest wander is 0.84 m in 30 s.
/// Smallest fault: no drift within 3 s (ClimbConsistency finds fast ones); 0.07 m/s after 15 s, 0.03 m/s after 34 s.
///
/// Eleven numbers; no heap. Cost: a square root and ten products a tick. T is float or double.
template <typename T>
class HeightConsistency {
 public:
  /// Once per tick.
  /// @param ours control is ours; the comparison starts anew whenever it becomes ours
  void update(const ImuSample<T>& imu, const Estimate<T>& estimate, bool ours, T step_s);

  bool contradicts() const { return cusum_.exceeds_threshold(); }
  /// The drift of the pose's height; positive: the pose reads high; m. Zero if the autopilot's height and climb speed
  /// do not agree on it.
  T drift_m() const { return drift_m_; }
  T allowed_m() const { return allowed_m_; }
  /// The part of the drift that exceeds kHeightWander_m; m.
  T unexplained_drift_m() const;
  /// Whether the poses have risen by 0.2 m more than the integral of the climb speed since the start. Alone this
  /// contradicts nothing. With a status "on the ground" it shows a drift (0.7 m in simulated drifts to the ground).
  bool reads_high() const { return by_climb_m_ > T(0.2); }

 private:
  void restart();

  bool begun_ = false;
  T elapsed_s_{0};  ///< since the start
  T since_s_{0};    ///< since the last comparison
  T offset_m_{0};   ///< pose height - autopilot's height at the start
  T by_height_m_{0};
  T by_climb_m_{0};
  T height_m_{0};  ///< the observer's, in the tick before
  T climb_m_s_{0};
  T climb_age_s_{1};
  T drift_m_{0};
  T allowed_m_{1};
  Cusum<T> cusum_;
};

extern template class HeightConsistency<float>;
extern template class HeightConsistency<double>;

}  // namespace m100::est
