// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/ground_station/goal_planner.h"

#include <algorithm>
#include <cmath>

#include "firmware/companion/ground_station/set_point_mask.h"
#include "firmware/core/frames.h"
#include "firmware/core/maths.h"

namespace m100::companion {
namespace {

constexpr double kShortestBrake_s = 0.5;
/// A stop takes this number times speed / acceleration limit: 3 / sqrt(2). The acceleration then never exceeds the
/// limit, if it does not at the beginning.
constexpr double kBrakeTime = 2.1213203435596424;
constexpr double kShortestWay_s = 0.3;
constexpr double kLonger = 1.06;  ///< ratio of successive durations that are tried
constexpr double kSamePlace_m = 1e-3;
constexpr double kSameYaw_rad = 1e-3;

/// From a motion to rest after a time, at whatever place; the acceleration is a parabola that ends at zero.
ref::Polynomial<double> to_rest(const ref::AxisReference<double>& from, double time_s) {
  const double slope = from.velocity_m_s * time_s, bend = from.acceleration_m_s2 * time_s * time_s;
  return {{from.position_m, slope, bend / 2.0, -slope - bend * 2.0 / 3.0, slope / 2.0 + bend / 4.0, 0.0, 0.0, 0.0}};
}

template <typename T>
double as_double(T value) {
  return static_cast<double>(value);
}

double speed_of(const std::array<ref::AxisReference<double>, ref::kDimensions>& motion) {
  const double x = motion[0].velocity_m_s, y = motion[1].velocity_m_s, z = motion[2].velocity_m_s;
  return core::sqrt(x * x + y * y + z * z);
}

template <typename T>
ref::Waypoint<T> place_of(const ref::Window<T>& window) {
  return {.position_w_m = {window.x[0].position_m, window.y[0].position_m, window.height.position_m},
          .yaw_rad = window.yaw_rad};
}

/// Copies the coordinates that the goal names into `place`. @returns kAccepted, or why one of them is not valid, and
/// then `value` is that one.
template <typename T>
GoalResult put(const mavlink::SetPositionTargetLocalNed& goal, ref::Waypoint<T>& place, double& value) {
  const std::array<float, 3> world{goal.x, -goal.y, -goal.z};  // NED to NWU
  for (unsigned axis = 0; axis < world.size(); ++axis) {
    if ((goal.type_mask & (1U << axis)) != 0) {
      continue;
    }
    if (!(std::abs(as_double(world[axis])) <= kFarthestSetPoint)) {
      value = as_double(axis == 0 ? world[axis] : -world[axis]);
      return GoalResult::kNotFinite;
    }
    place.position_w_m[static_cast<Eigen::Index>(axis)] = static_cast<T>(world[axis]);
  }
  if ((goal.type_mask & kIgnoreYaw) != 0) {
    return GoalResult::kAccepted;
  }
  if (!core::is_within_turn(goal.yaw)) {
    value = as_double(goal.yaw);
    return std::isfinite(goal.yaw) ? GoalResult::kDegrees : GoalResult::kNotFinite;
  }
  place.yaw_rad = core::wrap_pi(static_cast<T>(-goal.yaw));
  return GoalResult::kAccepted;
}

/// Whether the height is below the fence, and inside it if z had been sent with the other sign.
bool is_upward(const mavlink::SetPositionTargetLocalNed& goal, double height_m, const core::Fence::Side& height) {
  const double mirrored_m = height_m + 2.0 * as_double(goal.z);
  return (goal.type_mask & 0b100U) == 0 && height_m < height.low_m && mirrored_m >= height.low_m &&
         mirrored_m <= height.high_m;
}

}  // namespace

ref::Polynomial<double> polynomial_between(const ref::AxisReference<double>& from, const ref::AxisReference<double>& to,
                                           bool has_position, double time_s) {
  const double slope = from.velocity_m_s * time_s, bend = from.acceleration_m_s2 * time_s * time_s;
  const double turn = to.velocity_m_s * time_s - slope - bend;
  const double grows = to.acceleration_m_s2 * time_s * time_s - bend;
  if (!has_position) {
    return {{from.position_m, slope, bend / 2.0, turn - grows / 3.0, grows / 4.0 - turn / 2.0, 0.0, 0.0, 0.0}};
  }
  const double way = to.position_m - from.position_m - slope - bend / 2.0;
  return {{from.position_m, slope, bend / 2.0, 10.0 * way - 4.0 * turn + grows / 2.0, -15.0 * way + 7.0 * turn - grows,
           6.0 * way - 3.0 * turn + grows / 2.0, 0.0, 0.0}};
}

std::string_view name(GoalResult answer) {
  constexpr std::array<std::string_view, kGoalResults> kNames{
      // in the order of GoalResult
      "it flies there",
      "it flies there already",
      "refused: the aircraft does not fly by goals now",
      "refused: only the frame LOCAL_NED counts",
      "refused: a mask must name a position or a yaw",
      "refused: not finite, or farther than 1 km",
      "refused: a yaw beyond 2 pi: degrees? MAVLink's angles are radians",
      "refused: z lies below the fence and, with the other sign, inside it: MAVLink's z points down",
      "refused: the battery is low, and the aircraft flies to where the flight began",
      "refused: without a signature only the sender of --set-points-from counts",
      "a motion alone begins nothing",
      "a stream of set points, flown as it comes",
      "a stream that leads beyond the fence: it stays inside",
      "a stream that is too fast: the speed is cut to its limit",
      "a stream that needs too much tilt: the acceleration is cut to its limit",
      "a stream that is too far away to join: it flies there first",
      "the stream of set points has ended: it brakes and holds",
      "refused: set points of another sender lead, until they pause for 0.3 s",
      "refused: the masks of a stream must not change, until it pauses for 0.3 s",
      "refused: a mask must name position or velocity, each with all three axes, and no force",
      "refused: an order to hold stopped this stream, until it pauses for 0.3 s",
  };
  return kNames[static_cast<std::size_t>(answer)];
}

template <typename T>
ref::Waypoint<T> GoalPlanner<T>::clamp_to_fence(ref::Waypoint<T> place) const {
  for (std::size_t axis = 0; axis < fence_.side.size(); ++axis) {
    T& at = place.position_w_m[static_cast<Eigen::Index>(axis)];
    at = static_cast<T>(std::clamp(as_double(at), fence_.side[axis].low_m, fence_.side[axis].high_m));
  }
  return place;
}

template <typename T>
void GoalPlanner<T>::update(core::TimePoint now, bool by_law, core::TimePoint started,
                            const est::Estimate<T>& estimate) {
  if (by_law && started == started_) {
    return;
  }
  started_ = started;
  if (goal_) {  // the next flight does not begin on the way to that goal, but here
    ref::Waypoint<T> here;
    here.position_w_m = {estimate.x.position_m, estimate.y.position_m, estimate.height_m};
    here.yaw_rad = estimate.yaw_rad;
    goal_ = clamp_to_fence(here);
    trajectory_.hold(*goal_);
    trajectory_.start(now);
  }
}

template <typename T>
ref::Waypoint<T> GoalPlanner<T>::brake(core::TimePoint now) {
  const ref::Window<T> window = trajectory_.window(now, core::Duration{0});
  const auto motion = motion_of(window);
  const double speed = speed_of(motion);
  ref::Waypoint<T> here = place_of(window);
  trajectory_.hold(here);
  trajectory_.start(now);
  if (speed == 0.0 && motion[3].velocity_m_s == 0.0) {
    return here;
  }
  const double time_s = std::max(kShortestBrake_s, kBrakeTime * speed / limits_.acceleration_m_s2);
  PolynomialPath way;
  std::transform(motion.begin(), motion.end(), way.begin(), [&](const auto& axis) { return to_rest(axis, time_s); });
  (void)trajectory_.append_polynomial(way, core::Duration(std::llround(time_s * 1e6)));
  return trajectory_.end();
}

template <typename T>
bool GoalPlanner<T>::hold(core::TimePoint now, bool flies) {
  if (flies) {
    goal_ = brake(now);
  }
  return flies;
}

template <typename T>
GoalResult GoalPlanner<T>::take(const mavlink::SetPositionTargetLocalNed& goal, core::TimePoint now, bool flies,
                                const app::SourceFrame<T>& source) {
  refused_value_ = 0.0;
  if (goal.coordinate_frame != kLocalNed) {
    return GoalResult::kFrame;
  }
  if (ignores(goal, kIgnorePosition | kIgnoreYaw) || !names_only_a_place(goal)) {
    return GoalResult::kMask;
  }
  ref::Waypoint<T> place = goal_.value_or(trajectory_.end());
  place = {.position_w_m = source.to_source(place.position_w_m), .yaw_rad = place.yaw_rad - source.turn_rad()};
  if (const GoalResult read = put(goal, place, refused_value_); read != GoalResult::kAccepted) {
    return read;
  }
  if (!flies) {
    return GoalResult::kNotFlying;
  }
  place = {.position_w_m = source.to_flight(place.position_w_m),
           .yaw_rad = core::wrap_pi(place.yaw_rad + source.turn_rad())};
  const core::Vector<T, 3> named_w_m = place.position_w_m;
  if (is_upward(goal, as_double(named_w_m.z()), fence_.side[2])) {
    refused_value_ = as_double(goal.z);
    return GoalResult::kUpward;
  }
  place = clamp_to_fence(place);
  if (goal_ && as_double((place.position_w_m - goal_->position_w_m).norm()) < kSamePlace_m &&
      std::abs(core::wrap_pi(as_double(place.yaw_rad) - as_double(goal_->yaw_rad))) < kSameYaw_rad) {
    return GoalResult::kUnchanged;
  }
  cut_w_m_ = (place.position_w_m - named_w_m).cwiseAbs();
  return fly_to(place, now) ? GoalResult::kAccepted : GoalResult::kNotFinite;
}

template <typename T>
bool GoalPlanner<T>::fly_to(const ref::Waypoint<T>& place, core::TimePoint now) {
  const ref::Waypoint<T> end = clamp_to_fence(place);
  if (plan_to(end, now)) {
    goal_ = end;
    return true;
  }
  (void)brake(now);
  const core::Status laid = trajectory_.append_quintic(end, limits_);
  goal_ = laid == core::Status::kOk ? end : trajectory_.end();
  return laid == core::Status::kOk;
}

template <typename T>
bool GoalPlanner<T>::plan_to(const ref::Waypoint<T>& place, core::TimePoint now) {
  const ref::Window<T> window = trajectory_.window(now, core::Duration{0});
  const auto motion = motion_of(window);
  const double speed_m_s = speed_of(motion);
  if (speed_m_s == 0.0) {
    return false;  // from rest the straight way is used
  }
  const ref::Waypoint<T> here = place_of(window);
  const std::array<double, ref::kDimensions> ends{
      as_double(place.position_w_m.x()), as_double(place.position_w_m.y()), as_double(place.position_w_m.z()),
      as_double(here.yaw_rad) + core::wrap_pi(as_double(place.yaw_rad) - as_double(here.yaw_rad))};
  const double distance_m = as_double((place.position_w_m - here.position_w_m).norm());
  double time_s = std::max(kShortestWay_s, distance_m / limits_.speed_m_s);  // any shorter would be too fast
  for (int tries = 0; tries < kMaxAttempts; ++tries, time_s *= kLonger) {
    PolynomialPath way;
    for (std::size_t axis = 0; axis < way.size(); ++axis) {
      way[axis] = polynomial_between(motion[axis], {.position_m = ends[axis]}, true, time_s);
    }
    if (within_limits(way, time_s, speed_m_s)) {
      trajectory_.hold(here);
      trajectory_.start(now);
      return trajectory_.append_polynomial(way, core::Duration(std::llround(time_s * 1e6))) == core::Status::kOk;
    }
  }
  return false;
}

template <typename T>
bool GoalPlanner<T>::within_limits(const PolynomialPath& way, double time_s, double speed_m_s) const {
  const double max_m_s = std::max(speed_m_s, limits_.speed_m_s);  // a course may have been faster than goals
  for (int sample = 1; sample < kSamples; ++sample) {
    const double s = static_cast<double>(sample) / kSamples;
    double speed = 0.0, acceleration = 0.0;
    for (std::size_t axis = 0; axis < fence_.side.size(); ++axis) {
      const ref::AxisReference<double> at = way[axis].at(s, time_s);
      speed += at.velocity_m_s * at.velocity_m_s;
      acceleration += at.acceleration_m_s2 * at.acceleration_m_s2;
      // The start may lie outside, where a course of the operator led; the end lies inside.
      if (at.position_m < std::min(fence_.side[axis].low_m, way[axis].c[0]) ||
          at.position_m > std::max(fence_.side[axis].high_m, way[axis].c[0])) {
        return false;
      }
    }
    const double turn_rad_s = way[3].at(s, time_s).velocity_m_s;
    if (speed > max_m_s * max_m_s || acceleration > limits_.acceleration_m_s2 * limits_.acceleration_m_s2 ||
        std::abs(turn_rad_s) > limits_.yaw_rate_rad_s) {
      return false;
    }
  }
  return true;
}

template class GoalPlanner<float>;
template class GoalPlanner<double>;

}  // namespace m100::companion
