// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>

#include "firmware/core/fence.h"
#include "firmware/core/status.h"
#include "firmware/ref/trajectory.h"

namespace m100::app {

/// The fence of a board without files, in the world frame of the poses, around the courses below, and its wind class:
/// the numbers of the example flight file.
inline constexpr core::Fence kBoardFence{
    .side = {core::Fence::Side{-5.0, 5.0}, core::Fence::Side{-5.0, 5.0}, core::Fence::Side{0.5, 4.0}}, .wind_m_s = 5.0};

/// Largest distance from a course's beginning at which an order to fly is obeyed [m]; the companion has the same value.
inline constexpr double kBoardReach_m = 1.5;

/// The courses that a board without files can fly, by name: "hover" at 1.5 m, "step" (a metre in x and y, 0.2 m up, and
/// back) and "trajectory" (once around a square of one metre).
/// @returns kInvalidArgument: no course of that name. Otherwise as Trajectory's append functions.
template <typename T>
core::Status append_board_course(std::string_view name, ref::Trajectory<T>& course) {
  using namespace std::chrono_literals;
  const auto place = [](T x_m, T y_m, T z_m) {
    return ref::Waypoint<T>{.position_w_m = {x_m, y_m, z_m}, .yaw_rad = T(0)};
  };
  const ref::Waypoint<T> start = place(T(0), T(0), T(1.5));
  course.hold(start);
  if (name == "hover") {
    return core::Status::kOk;
  }
  if (name != "step" && name != "trajectory") {
    return core::Status::kInvalidArgument;
  }
  const core::Status waits = course.append_step(start, 2s);
  if (waits != core::Status::kOk || name == "trajectory") {
    return waits != core::Status::kOk ? waits : course.append_square(T(1), 2500ms, 500ms);
  }
  const core::Status goes = course.append_step(place(T(1), T(1), T(1.7)), 5s);
  return goes != core::Status::kOk ? goes : course.append_step(start, 8s);
}

}  // namespace m100::app
