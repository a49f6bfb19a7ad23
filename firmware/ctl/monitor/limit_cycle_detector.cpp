// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/ctl/monitor/limit_cycle_detector.h"

#include "firmware/core/maths.h"
#include "firmware/model/vehicle.h"

namespace m100::ctl {
namespace {

constexpr double kComesBack = 0.25;  ///< share of the half-wave before, by which the tilt comes back after turning
constexpr double kPiSquare = core::kPi * core::kPi;

template <typename T>
T size_of(T value) {
  return value < T(0) ? -value : value;
}

template <typename T>
T larger(T a, T b) {
  return a > b ? a : b;
}

}  // namespace

/// Starts in the steady state of a constant tilt.
template <typename T>
void LimitCycleDetector<T>::UnexplainedMotion::begin(T position_m, T acceleration_m_s2) {
  constexpr T kTime_s = static_cast<T>(1.0 / kFrom_per_s);
  slow_m = position_m;
  slower_m = T(0);
  carried_m_s = acceleration_m_s2 * kTime_s;
  carried_m = carried_m_s * kTime_s;
  value_m = -carried_m;
}

template <typename T>
void LimitCycleDetector<T>::UnexplainedMotion::update(T position_m, T acceleration_m_s2, T step_s) {
  constexpr T kRate = static_cast<T>(kFrom_per_s);
  slow_m += kRate * step_s * (position_m - slow_m);
  const T quick_m = position_m - slow_m;
  slower_m += kRate * step_s * (quick_m - slower_m);
  carried_m_s += step_s * (acceleration_m_s2 - kRate * carried_m_s);
  carried_m += step_s * (carried_m_s - kRate * carried_m);
  value_m = quick_m - slower_m - carried_m;
}

/// The extreme was a turning point: counts the half-wave that led to it if it meets the conditions.
template <typename T>
void LimitCycleDetector<T>::turn(Axis& axis) {
  constexpr T kPerGravity = static_cast<T>(1.0 / model::kGravity_m_s2);
  constexpr T kRatio = static_cast<T>(kMaxPeriodRatio);
  const T height_rad = size_of(axis.extreme_rad - axis.turning_point_rad);
  const T length_s = axis.age_s - axis.extreme_age_s;
  const bool long_enough = length_s > static_cast<T>(kMinHalfWave_s) && length_s < static_cast<T>(kMaxHalfWave_s);
  // Inverts the filter at the half-wave's frequency: converts unexplained metres to the tilt that would cause them.
  const T shortest_s = long_enough ? length_s : static_cast<T>(kMinHalfWave_s);
  const T per_metre =
      kPerGravity * (static_cast<T>(kFrom_per_s * kFrom_per_s) + static_cast<T>(kPiSquare) / (shortest_s * shortest_s));
  const T pushed_rad = larger(per_metre * axis.unexplained_m.size(), axis.disturbed_rad.size());
  const bool own = height_rad > static_cast<T>(kMinHeight_rad) &&
                   height_rad > static_cast<T>(kMinRatio) * pushed_rad + axis.reference_rad.size();
  const bool alike = height_rad > static_cast<T>(kMinHeightRatio) * axis.height_rad &&
                     length_s < kRatio * axis.length_s && axis.length_s < kRatio * length_s;
  const bool one_more = own && long_enough && alike;
  axis.count = one_more ? axis.count + 1U : own && long_enough ? 1U : 0U;
  axis.height_rad = one_more && axis.count > 1 ? larger(height_rad, axis.height_rad) : height_rad;
  axis.length_s = length_s;
  axis.turning_point_rad = axis.extreme_rad;
  axis.age_s = axis.extreme_age_s;
  axis.rises = !axis.rises;
}

template <typename T>
bool LimitCycleDetector<T>::jumps(Axis& axis, const ref::AxisReference<T>& reference, T step_s) {
  const T away_m = reference.position_m - axis.ref_position_m - step_s * reference.velocity_m_s;
  const T faster_m_s = reference.velocity_m_s - axis.ref_velocity_m_s;
  axis.ref_position_m = reference.position_m;
  axis.ref_velocity_m_s = reference.velocity_m_s;
  return size_of(away_m) > static_cast<T>(kJump_m) || size_of(faster_m_s) > static_cast<T>(kJump_m_s);
}

template <typename T>
void LimitCycleDetector<T>::update_axis(Axis& axis, const est::AxisEstimate<T>& estimate,
                                        const ref::AxisReference<T>& reference, T sign, T step_s) const {
  constexpr T kGravity = static_cast<T>(model::kGravity_m_s2);
  constexpr T kPerGravity = static_cast<T>(1.0 / model::kGravity_m_s2);
  const T reference_rad = sign * kPerGravity * reference.acceleration_m_s2;
  const T disturbed_rad = kPerGravity * estimate.disturbance_m_s2;
  const T tilt_rad = estimate.tilt_rad - reference_rad;
  const T carries_m_s2 = sign * kGravity * estimate.tilt_rad;
  const bool jumped = jumps(axis, reference, step_s);
  if (!watches_) {
    axis.unexplained.begin(estimate.position_m, carries_m_s2);
  } else {
    axis.unexplained.update(estimate.position_m, carries_m_s2, step_s);
  }
  const bool anew = jumped || !watches_;
  axis.age_s += step_s;
  axis.extreme_age_s += step_s;
  const T beyond_rad = axis.rises ? tilt_rad - axis.extreme_rad : axis.extreme_rad - tilt_rad;
  const T back_rad = static_cast<T>(kComesBack) * larger(axis.height_rad, static_cast<T>(kMinHeight_rad));
  const bool turned = !anew && beyond_rad < -back_rad;
  if (turned) {
    turn(axis);
  } else if (anew) {
    axis.turning_point_rad = tilt_rad;
    axis.age_s = axis.height_rad = axis.length_s = T(0);
    axis.count = 0;
  } else if (axis.age_s > static_cast<T>(2.0 * kMaxHalfWave_s)) {
    axis.count = 0;  // it has come to rest
  }
  if (turned || anew || beyond_rad > T(0)) {
    axis.extreme_rad = tilt_rad;
    axis.extreme_age_s = T(0);
  }
  if (turned || anew) {
    axis.unexplained_m.begin(axis.unexplained.value_m);
    axis.disturbed_rad.begin(disturbed_rad);
    axis.reference_rad.begin(reference_rad);
  } else {
    axis.unexplained_m.add(axis.unexplained.value_m);
    axis.disturbed_rad.add(disturbed_rad);
    axis.reference_rad.add(reference_rad);
  }
}

template <typename T>
void LimitCycleDetector<T>::update(const est::Estimate<T>& estimate, const ref::Window<T>& window, bool flies,
                                   T step_s) {
  away_s_ -= step_s < away_s_ ? step_s : away_s_;
  const bool can = flies && away_s_ <= T(0) && step_s < static_cast<T>(kStall_s);
  watches_ = watches_ && can;
  enough_ = flies ? enough_ : kHalfWaves;
  update_axis(x_, estimate.x, window.x[0], T(1), step_s);
  update_axis(y_, estimate.y, window.y[0], T(-1), step_s);
  watches_ = can;
}

template <typename T>
void LimitCycleDetector<T>::pause(T time_s) {
  x_.count = y_.count = 0;
  enough_ = kHalfWavesAgain;
  away_s_ = time_s;
}

template <typename T>
LimitCycleReport<T> LimitCycleDetector<T>::report() const {
  const bool x = x_.count >= enough_;
  const bool y = y_.count >= enough_;
  if (!x && !y) {
    return {};
  }
  const Axis& axis = !x || (y && y_.height_rad > x_.height_rad) ? y_ : x_;
  return {.detected = true, .height_rad = axis.height_rad, .frequency_hz = T(0.5) / axis.length_s};
}

template class LimitCycleDetector<float>;
template class LimitCycleDetector<double>;

}  // namespace m100::ctl
