// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "firmware/ref/window.h"

namespace m100::ref {

/// What one axis can do, all positive: m/s, m/s^2, m/s^3.
template <typename T>
struct AxisLimits {
  T speed_m_s{0};
  T up_m_s2{0};        ///< acceleration towards +
  T down_m_s2{0};      ///< acceleration towards -
  T braking_share{1};  ///< of `up` and `down`: what the final braking uses, at most 1
  T jerk_m_s3{0};      ///< rate of the acceleration
  T release_m_s3{0};   ///< rate of the acceleration where the final braking ends, at most jerk_m_s3
};

/// The fastest motion of one axis from any position, velocity and acceleration to rest at a goal, with limited speed,
/// acceleration and jerk. The acceleration rises to a peak, stays, falls to a minimum (`trough`), stays, and returns to
/// zero; if the speed limit is reached, a cruise lies in the middle. There are at most seven pieces of constant jerk,
/// and one before them if the first acceleration exceeds its limit.
///
/// A bracketed secant of at most kMaxSteps steps finds the peak, or how long it stays. A speed above its limit at the
/// beginning is not increased. Cost: at most kMaxSteps + 8 square roots; no allocation. T is float or double, the same
/// bits on every machine.
template <typename T>
class TimeOptimal {
 public:
  static constexpr int kMaxSteps = 24;

  /// Replaces the motion by rest at a goal.
  void rest(T goal_m);
  /// Where the axis comes to rest if it brakes at once.
  static T stop_m(const AxisReference<T>& from, const AxisLimits<T>& limits);
  /// Plans from a state to rest at `goal_m`.
  void plan(const AxisReference<T>& from, T goal_m, const AxisLimits<T>& limits);
  /// The motion at a time since its beginning; from duration_s() on exactly the goal, at rest.
  AxisReference<T> at(T time_s) const;
  /// The motion at first_s, first_s + 0.1 s, ...: one walk over the pieces.
  void fill(std::span<AxisReference<T>> window, T first_s) const;
  T duration_s() const { return duration_s_; }
  T goal_m() const { return goal_m_; }

 private:
  struct Piece {
    T duration_s{0};
    T jerk_m_s3{0};
  };
  static constexpr std::size_t kPieces = 8;
  class Search;
  class Walk;
  static Piece back_to_limits(T acceleration_m_s2, const AxisLimits<T>& limits);

  std::array<Piece, kPieces> pieces_{};
  AxisReference<T> from_{};  ///< the position is relative to the goal
  T goal_m_{0};
  T duration_s_{0};
};

extern template class TimeOptimal<float>;
extern template class TimeOptimal<double>;

}  // namespace m100::ref
