// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "firmware/app/source_frame.h"
#include "firmware/core/eigen.h"
#include "firmware/core/fence.h"
#include "firmware/core/time.h"
#include "firmware/est/estimate.h"
#include "firmware/ref/trajectory.h"
#include "protocol/mavlink/command_messages.h"

namespace m100::companion {

/// The answer to a goal.
enum class GoalResult : std::uint8_t {
  kAccepted,
  kUnchanged,
  kNotFlying,
  kFrame,
  kMask,
  kNotFinite,
  kDegrees,
  kUpward,
  kReturningToStart,
  kUnsigned,
  // Of a stream; SetPointStream::exceeding() has the number.
  kFirst,  ///< a motion alone: nothing yet
  kStream,
  kStreamFence,
  kStreamSpeed,
  kStreamAcceleration,
  kStreamFar,
  kStreamEnded,
  kSecondSender,
  kMixedMasks,
  kPartialMask,
  kHeld
};
inline constexpr std::size_t kGoalResults = static_cast<std::size_t>(GoalResult::kHeld) + 1;
constexpr bool is_stream(GoalResult answer) {
  return answer >= GoalResult::kStream && answer <= GoalResult::kStreamFar;
}
/// "refused: only the frame LOCAL_NED counts", for people.
std::string_view name(GoalResult answer);

/// From one motion to another, in normalised time: of degree 5, or 4 where the place of the end is free.
ref::Polynomial<double> polynomial_between(const ref::AxisReference<double>& from, const ref::AxisReference<double>& to,
                                           bool has_position, double time_s);

/// The present motion in x, y, z and yaw.
template <typename T>
std::array<ref::AxisReference<double>, ref::kDimensions> motion_of(const ref::Window<T>& window) {
  std::array<ref::AxisReference<double>, ref::kDimensions> motion;
  const ref::AxisReference<T> yaw{.position_m = window.yaw_rad, .velocity_m_s = window.yaw_rate_rad_s};
  std::size_t axis = 0;
  for (const ref::AxisReference<T>* const one : {&window.x[0], &window.y[0], &window.height, &yaw}) {
    motion[axis++] = {.position_m = static_cast<double>(one->position_m),
                      .velocity_m_s = static_cast<double>(one->velocity_m_s),
                      .acceleration_m_s2 = static_cast<double>(one->acceleration_m_s2)};
  }
  return motion;
}

/// Turns goals into a course during the flight. A goal is a place where the aircraft comes to rest. From rest the way
/// there is straight, of degree 5, as fast as the limits allow. If a goal arrives on the way, the new way starts from
/// the present motion, provided that one polynomial of degree 5 per axis keeps the limits and the fence. Otherwise the
/// reference first comes to rest (degree 4), and if it accelerates at that moment, it first becomes faster: by 17 % of
/// its speed, or 0.08 s times the acceleration limit if that is more. This stop alone may exceed the speed limit.
/// Place, speed and acceleration never jump. Goals beyond the fence are moved to its side.
///
/// Cost of a goal that arrives on the way: at most kMaxAttempts * kSamples evaluations of four polynomials.
///
/// Goals are taken only while the law flies. A flight that begins after a flight to goals holds the place where it
/// begins until the next goal arrives. No heap.
template <typename T>
class GoalPlanner {
 public:
  GoalPlanner(ref::Trajectory<T>& trajectory, const core::Fence& fence, const ref::SpeedLimits& limits)
      : trajectory_(trajectory), fence_(fence), limits_(limits) {}

  /// Call it after each tick. After a flight to goals the next flight begins where the aircraft is.
  /// @param by_law the law flies. @param started when the trajectory's time last began. @param estimate of this tick.
  void update(core::TimePoint now, bool by_law, core::TimePoint started, const est::Estimate<T>& estimate);
  /// Takes a goal. What it does not name (x, y, z or yaw) stays as in goal(), or as at the course's end.
  /// @param flies control is ours, and the failsafe passes commands of the law.
  /// @param source the world of the goal.
  GoalResult take(const mavlink::SetPositionTargetLocalNed& goal, core::TimePoint now, bool flies,
                  const app::SourceFrame<T>& source = {});
  /// Flies to a place, or to the nearest inside the fence. Call it only while the law flies. @returns false: it cannot;
  /// the reference comes to rest.
  bool fly_to(const ref::Waypoint<T>& place, core::TimePoint now);
  /// The next flight begins where the aircraft is, as after a flight to goals.
  void stay() { goal_ = trajectory_.end(); }
  /// Brings the reference to rest on its way. @returns false: the law does not fly.
  bool hold(core::TimePoint now, bool flies);

  /// The last accepted goal, or where a hold or the begin of a later flight put it; nullopt: the course applies.
  const std::optional<ref::Waypoint<T>>& goal() const { return goal_; }
  /// How far the fence moved the last accepted goal along each axis of the flight's world.
  const core::Vector<T, 3>& cut_w_m() const { return cut_w_m_; }
  /// The number for which take() refused the last goal, as it was sent; 0: it refused none.
  double refused_value() const { return refused_value_; }
  /// The reference has reached its end and rests.
  bool at_rest(core::TimePoint now) const { return trajectory_.finished(now); }
  /// @returns the place, or the nearest one inside the fence.
  ref::Waypoint<T> clamp_to_fence(ref::Waypoint<T> place) const;

 private:
  static constexpr int kMaxAttempts = 50;  ///< durations tried for a way from a motion
  static constexpr int kSamples = 20;      ///< times per way that are checked against the limits
  /// x, y, z, yaw.
  using PolynomialPath = std::array<ref::Polynomial<double>, ref::kDimensions>;

  /// Sets the fastest way found from the present motion to rest at a place, inside limits and fence. @returns false:
  /// none is found, or the reference is at rest.
  bool plan_to(const ref::Waypoint<T>& place, core::TimePoint now);
  bool within_limits(const PolynomialPath& way, double time_s, double speed_m_s) const;
  /// Begins the trajectory anew, from its present motion to rest. @returns where it ends.
  ref::Waypoint<T> brake(core::TimePoint now);

  ref::Trajectory<T>& trajectory_;
  core::Fence fence_;
  ref::SpeedLimits limits_;
  std::optional<ref::Waypoint<T>> goal_;
  core::Vector<T, 3> cut_w_m_ = core::Vector<T, 3>::Zero();
  double refused_value_ = 0.0;
  core::TimePoint started_{};
};

extern template class GoalPlanner<float>;
extern template class GoalPlanner<double>;

}  // namespace m100::companion
