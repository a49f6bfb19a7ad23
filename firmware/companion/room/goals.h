// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "firmware/core/eigen.h"
#include "firmware/core/fence.h"
#include "firmware/core/time.h"
#include "firmware/est/estimate.h"
#include "firmware/ref/trajectory.h"
#include "protocol/mavlink/order_messages.h"

namespace m100::companion {

/// What became of a goal.
enum class GoalAnswer : std::uint8_t { kFlies, kSame, kNotFlying, kFrame, kMask, kNoNumber, kGoesHome };
/// "refused: only positions, and a yaw, in LOCAL_NED count", for people.
std::string_view name(GoalAnswer answer);

/// Turns goals into a course, in flight. A goal is a place to be at rest at; the way there is straight, of degree 5, as
/// fast as the limits allow. A goal that comes on the way is flown to from the motion of that moment, without a stop,
/// where one polynomial of degree 5 for each axis does that inside the limits and inside the fence; else the reference
/// first comes to rest on its way (degree 7). So speed and acceleration stay inside their limits whatever is asked for,
/// and place, speed and acceleration never jump. Goals beyond the fence are moved to its side; the fence keeper holds
/// the reference and the speed inside, as it does for any course.
///
/// Cost of a goal that comes on the way: at most kTries * kSamples evaluations of four polynomials.
///
/// Nobody's goal moves anything: what does not fly takes none, and a flight that begins anew holds its place until the
/// next one comes. Bounded, no heap; a log replays it from the bytes of the pose port.
template <typename T>
class Goals {
 public:
  Goals(ref::Trajectory<T>& trajectory, const core::Fence& fence, const ref::SpeedLimits& limits)
      : trajectory_(trajectory), fence_(fence), limits_(limits) {}

  /// After each tick. Where goals have led the flight, the next one begins where the aircraft is.
  /// @param by_law the law flies. @param started when the trajectory's time began last. @param estimate of this tick.
  void watch(core::TimePoint now, bool by_law, core::TimePoint started, const est::Estimate<T>& estimate);
  /// @param flies the ladder lets commands of the law through.
  GoalAnswer take(const mavlink::SetPositionTargetLocalNed& goal, core::TimePoint now, bool flies);
  /// To a place, or to the side of the fence next to it. Only while it flies. @returns false: it is no place.
  bool fly_to(const ref::Waypoint<T>& place, core::TimePoint now);
  /// To rest, on the way. @returns false: nothing flies.
  bool hold(core::TimePoint now, bool flies);

  /// The last that was accepted, world frame; nothing: the course that the flight began with.
  const std::optional<ref::Waypoint<T>>& goal() const { return goal_; }
  /// The reference has come to where it shall be at rest.
  bool rests(core::TimePoint now) const { return trajectory_.finished(now); }
  /// Where the reference is and looks, world frame.
  core::Vector<T, 3> reference(core::TimePoint now) const {
    const ref::Window<T> window = trajectory_.window(now, core::Duration{0});
    return {window.x[0].position_m, window.y[0].position_m, window.height.position_m};
  }
  T yaw(core::TimePoint now) const { return trajectory_.window(now, core::Duration{0}).yaw_rad; }
  /// @returns the place, or the one at the side of the fence next to it.
  ref::Waypoint<T> inside(ref::Waypoint<T> place) const;

 private:
  static constexpr int kTries = 50;    ///< durations of a way from a motion
  static constexpr int kSamples = 20;  ///< of each, held to the limits
  /// x, y, z, yaw.
  using Way = std::array<ref::Polynomial<double>, ref::kDimensions>;

  /// The shortest way from the motion of now to rest at a place that keeps limits and fence. @returns false: none does.
  bool turn_to(const ref::Waypoint<T>& place, core::TimePoint now);
  bool keeps_limits(const Way& way, double time_s, double speed_m_s) const;
  /// Begins the trajectory anew: from its motion now to rest. @returns where that ends.
  ref::Waypoint<T> brake(core::TimePoint now);

  ref::Trajectory<T>& trajectory_;
  core::Fence fence_;
  ref::SpeedLimits limits_;
  std::optional<ref::Waypoint<T>> goal_;
  core::TimePoint started_{};
};

extern template class Goals<float>;
extern template class Goals<double>;

}  // namespace m100::companion
