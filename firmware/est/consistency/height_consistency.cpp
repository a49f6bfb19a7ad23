// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/est/consistency/height_consistency.h"

namespace m100::est {
namespace {

/// In kWander_s the error of the autopilot's height may change by kHeightWander_m (measured logs: 0.25 to 0.84 m).
constexpr double kHeightWander_m = 0.84, kWander_s = 30.0;
constexpr double kClimbAge_s = 0.2;  ///< an older climb speed is not integrated: it comes at 10 Hz or more
constexpr double kPoseUsed_s = 0.3;  ///< PathMonitor::kPoseUsed: with an older pose the height is a prediction
constexpr double kLongest_s = 3600.0;
constexpr double kSane_m = 1e4;

template <typename T>
T magnitude(T value) {
  return value < T(0) ? -value : value;
}

/// The mean if both have the same sign and neither is more than twice the other, otherwise zero.
template <typename T>
T agreed(T a, T b) {
  const bool agree =
      (a < T(0)) == (b < T(0)) && magnitude(a) <= T(2) * magnitude(b) && magnitude(b) <= T(2) * magnitude(a);
  return agree ? T(0.5) * (a + b) : T(0);
}

}  // namespace

template <typename T>
void HeightConsistency<T>::restart() {
  begun_ = false;
  elapsed_s_ = since_s_ = by_height_m_ = by_climb_m_ = drift_m_ = T(0);
  allowed_m_ = static_cast<T>(kHeightWander_m);
  cusum_ = {};
}

template <typename T>
void HeightConsistency<T>::update(const ImuSample<T>& imu, const Estimate<T>& estimate, bool ours, T step_s) {
  climb_m_s_ = imu.climb_is_new ? imu.climb_m_s : climb_m_s_;
  climb_age_s_ = imu.climb_is_new ? T(0) : core::clamp(climb_age_s_ + step_s, T(0), T(1));
  const T risen_m = estimate.height_m - height_m_;
  height_m_ = estimate.height_m;
  if (!ours || !(magnitude(by_height_m_) + magnitude(by_climb_m_) < static_cast<T>(kSane_m))) {
    restart();
    return;
  }
  if (!begun_) {  // the first height of the autopilot is the reference
    offset_m_ = estimate.height_m - imu.height_m;
    begun_ = imu.height_is_new && estimate.healthy;
    return;
  }
  since_s_ = core::clamp(since_s_ + step_s, T(0), T(1));
  elapsed_s_ = core::clamp(elapsed_s_ + step_s, T(0), static_cast<T>(kLongest_s));
  by_climb_m_ += climb_age_s_ < static_cast<T>(kClimbAge_s) ? risen_m - climb_m_s_ * step_s : T(0);
  if (!imu.height_is_new || !estimate.healthy || core::seconds<T>(estimate.pose_age) > static_cast<T>(kPoseUsed_s)) {
    return;
  }
  by_height_m_ = estimate.height_m - imu.height_m - offset_m_;
  drift_m_ = agreed(by_height_m_, by_climb_m_);
  allowed_m_ = static_cast<T>(kHeightWander_m) *
               core::sqrt(core::clamp(elapsed_s_ * static_cast<T>(1.0 / kWander_s), T(1), static_cast<T>(kLongest_s)));
  cusum_.add(magnitude(drift_m_), allowed_m_, since_s_);
  since_s_ = T(0);
}

template <typename T>
T HeightConsistency<T>::unexplained_drift_m() const {
  constexpr T kWander = static_cast<T>(kHeightWander_m);
  return drift_m_ - core::clamp(drift_m_, -kWander, kWander);
}

template class HeightConsistency<float>;
template class HeightConsistency<double>;

}  // namespace m100::est
