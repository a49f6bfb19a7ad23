// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/files/flight_limits.h"

#include <algorithm>
#include <cmath>

#include "firmware/companion/files/text/toml_text.h"
#include "firmware/core/maths.h"
#include "firmware/model/vehicle.h"

namespace m100::companion {
namespace {

core::Duration or_else(double seconds, core::Duration otherwise) {
  return seconds > 0.0 ? core::Duration(std::llround(seconds * 1e6)) : otherwise;
}

constexpr double kRounding_m = 1e-3;  ///< poses are exact to millimetres; a course along the fence counts as inside

/// One axis of a place, and the fence's range on this axis.
struct Side {
  const char* axis;
  double at_m;
  Range box;
};

}  // namespace

core::Fence fence_of(const FlightFile& flight, const ref::Waypoint<double>& start) {
  const auto side = [](const Range& range, double from_m) {
    return core::Fence::Side{.low_m = from_m + range.low, .high_m = from_m + range.high};
  };
  return {.side = {side(flight.fence_x_m, start.position_w_m.x()), side(flight.fence_y_m, start.position_w_m.y()),
                   side(flight.fence_z_m, 0.0)},
          .wind_m_s = flight.wind_m_s};
}

safety::Limits limits_of(const FlightFile& flight) {
  safety::Limits limits;
  limits.pose_fresh = or_else(flight.pose_fresh_s, limits.pose_fresh);
  limits.pose_fresh_is_set = flight.pose_fresh_s > 0.0;
  limits.coast = or_else(flight.pose_coast_s, limits.coast);
  limits.level = or_else(flight.pose_level_s, limits.level);
  return limits;
}

CourseLimits course_limits_of(const FlightFile& flight) {
  CourseLimits limits;
  const auto take = [](double said, double unit, double& limit) { limit = said > 0.0 ? said * unit : limit; };
  take(flight.course_speed_m_s, 1.0, limits.speed_m_s);
  take(flight.course_acceleration_m_s2, 1.0, limits.acceleration_m_s2);
  take(flight.course_tilt_deg, core::kDegree_rad, limits.tilt_rad);
  take(flight.course_yaw_rate_deg_s, core::kDegree_rad, limits.yaw_rate_rad_s);
  return limits;
}

ref::SpeedLimits goal_limits_of(const FlightFile& flight) {
  const CourseLimits course = course_limits_of(flight);
  ref::SpeedLimits limits;
  limits.speed_m_s = std::min({limits.speed_m_s, course.speed_m_s, course.climb_m_s});
  limits.acceleration_m_s2 =
      std::min({limits.acceleration_m_s2, course.acceleration_m_s2, model::kGravity_m_s2 * std::sin(course.tilt_rad)});
  limits.yaw_rate_rad_s = std::min(limits.yaw_rate_rad_s, course.yaw_rate_rad_s);
  return limits;
}

StreamLimits stream_limits_of(const FlightFile& flight) {
  const CourseLimits course = course_limits_of(flight);
  return {.speed_m_s = std::isfinite(course.speed_m_s) ? course.speed_m_s : goal_limits_of(flight).speed_m_s,
          .acceleration_m_s2 = std::min(course.acceleration_m_s2, model::kGravity_m_s2 * std::sin(course.tilt_rad)),
          .climb_m_s = course.climb_m_s,
          .yaw_rate_rad_s = course.yaw_rate_rad_s};
}

void validate_inside_fence(const FlightFile& flight, const ref::Waypoint<double>& start,
                           const ref::Trajectory<double>& course, std::span<const CoursePiece> pieces,
                           const std::string& course_name) {
  const auto expect = [&](const core::Vector<double, 3>& place_w_m, const auto& who, const auto& when) {
    const core::Vector<double, 3> offset_m = place_w_m - start.position_w_m;
    for (const Side& side : {Side{"x", offset_m.x(), flight.fence_x_m}, Side{"y", offset_m.y(), flight.fence_y_m},
                             Side{"z", place_w_m.z(), flight.fence_z_m}}) {
      if (!Range{side.box.low - kRounding_m, side.box.high + kRounding_m}.contains(side.at_m)) {
        throw FileError(who() + ": " + side.axis + " = " + text_of(side.at_m) + " m is outside the fence, " +
                        side.axis + "_m = " + text_of(side.box) + when());
      }
    }
  };
  expect(
      start.position_w_m, [] { return std::string("the start of the flight"); }, [] { return std::string(); });
  for_each_sample(course, pieces, [&](const CoursePiece& piece, core::Duration at, const ref::Motion& motion) {
    expect(
        {motion[0][0], motion[1][0], motion[2][0]},
        [&] { return course_name + ":" + std::to_string(piece.line) + ": '" + piece.word + "'"; },
        [&] { return ", " + when_and_where(at, motion, start); });
  });
}

}  // namespace m100::companion
