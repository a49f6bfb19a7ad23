// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <deque>
#include <vector>

#include "firmware/companion/doctor/check.h"
#include "firmware/core/eigen.h"
#include "firmware/core/frames.h"
#include "firmware/core/pose.h"
#include "firmware/core/time.h"

namespace m100::companion::doctor {

/// Finds the axes of the pose that are turned, exchanged or mirrored, from an aircraft that is moved by hand: nothing
/// but motion tells one axis from another. Three comparisons, each free of the headings of the two worlds:
///
///   tilt      the direction of up in the body: of the pose against the autopilot's attitude. Roll and pitch.
///   turning   how far the heading turned in 0.2 s: of the pose against the autopilot's.
///   position  p(t+h) - 2 p(t) + p(t-h) of the pose, over h^2, is the acceleration weighted by a triangle over 2 h; the
///             same mean of the specific force less gravity, turned into the world by the autopilot's tilt and the
///             pose's heading. x, y, z of the world. The mean length of the specific force is taken for g, whatever its
///             unit is.
///
/// Each is a matrix of correlations; the signed axis that explains most is the one that is said. Companion only: it
/// uses the heap.
class FramesCheck {
 public:
  /// One visit: what was heard last on either side.
  struct Sample {
    core::TimePoint at{};
    core::Vector<double, 3> position_w_m = core::Vector<double, 3>::Zero();
    core::Quaternion<double> pose_wb{};                                 ///< body to the pose's world
    core::Quaternion<double> autopilot_wb{};                            ///< body to the autopilot's, FLU and NWU
    core::Vector<double, 3> force_b = core::Vector<double, 3>::Zero();  ///< specific force, FLU, m/s^2 or g
  };
  /// 100 samples a second, evenly.
  void add(const Sample& sample);
  /// One for each axis: pitch, roll, heading, x, y, z. kDoubtful: it was not moved enough, or the pose does not tell
  /// it.
  std::vector<Check> checks() const;
  std::size_t samples() const { return samples_; }

 private:
  static constexpr std::size_t kSpan = 20;  ///< h of the second difference, and of a turn: 0.2 s

  void add_tilt(const Sample& sample);
  void add_turn(const Sample& then, const Sample& now);
  void add_position();

  std::deque<Sample> window_;  ///< of 2 kSpan + 1
  std::size_t samples_ = 0;
  // Sums of products. Rows are the pose's axes, columns the autopilot's; means are taken out at the end.
  Eigen::Matrix2d tilt_products_ = Eigen::Matrix2d::Zero();
  Eigen::Vector2d tilt_pose_ = Eigen::Vector2d::Zero(), tilt_autopilot_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d tilt_pose_squares_ = Eigen::Vector2d::Zero(), tilt_autopilot_squares_ = Eigen::Vector2d::Zero();
  double upright_ = 0.0;  ///< sum of the products of the two z
  double turn_products_ = 0.0, turn_pose_squares_ = 0.0, turn_autopilot_squares_ = 0.0;
  Eigen::Matrix3d position_products_ = Eigen::Matrix3d::Zero();
  Eigen::Vector3d position_pose_squares_ = Eigen::Vector3d::Zero(), position_force_squares_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d position_pose_ = Eigen::Vector3d::Zero(), position_force_ = Eigen::Vector3d::Zero();
  std::size_t positions_ = 0;
  double force_length_ = 0.0;  ///< sum
};

}  // namespace m100::companion::doctor
