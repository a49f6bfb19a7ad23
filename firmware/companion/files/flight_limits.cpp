// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/files/flight_limits.h"

#include <algorithm>
#include <cmath>

#include "firmware/core/maths.h"
#include "firmware/model/vehicle.h"

namespace m100::companion {
namespace {

core::Duration or_else(double seconds, core::Duration otherwise) {
  return seconds > 0.0 ? core::Duration(std::llround(seconds * 1e6)) : otherwise;
}

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

}  // namespace m100::companion
