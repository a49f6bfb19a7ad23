// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <vector>

#include "firmware/companion/preflight/check_result.h"
#include "firmware/core/eigen.h"
#include "firmware/core/frames.h"
#include "firmware/core/pose.h"
#include "firmware/core/time.h"
#include "firmware/est/consistency/velocity_consistency.h"

namespace m100::companion::preflight {

/// Finds the axes of the pose that are turned, exchanged or mirrored, while the aircraft is moved by hand: only motion
/// distinguishes the axes. It makes three comparisons, none of which needs the angle between the two worlds:
///
///   tilt      the direction of up in the body, by the pose and by the autopilot's attitude: roll and pitch.
///   turning   the change of heading in 0.2 s, by the pose and by the autopilot.
///   position  p(t+h) - 2 p(t) + p(t-h) of the pose, over h^2: the acceleration weighted by a triangle over 2 h;
///             and the same mean of the specific force less gravity, rotated into the world by the autopilot's tilt and
///             the pose's heading: x, y, z of the world; while it does not turn, because a lever arm would move the
///             pose alone. The mean length of the specific force is taken as g, whatever
///             its unit is.
///
/// Each comparison correlates the axes of the pose with those of the autopilot. The largest correlation of each axis
/// must be with the same axis of the autopilot, and positive. A turn about the vertical also shows the lever arm from
/// the centre of gravity to the origin of the pose (est::LeverArmFit). Companion only: it uses the heap.
class AxisAlignment {
 public:
  /// The newest pose and the newest telemetry at one time.
  struct Sample {
    core::TimePoint at{};
    core::Vector<double, 3> position_w_m = core::Vector<double, 3>::Zero();
    core::Quaternion<double> pose_wb{};       ///< body to the pose's world
    core::Quaternion<double> autopilot_wb{};  ///< body to the autopilot's world; FLU and NWU, both quaternions
    core::Vector<double, 3> force_b = core::Vector<double, 3>::Zero();  ///< specific force, FLU, m/s^2 or g
  };
  /// Adds a sample; the caller adds 100 a second, evenly spaced.
  void add(const Sample& sample);
  /// One check for each axis: pitch, roll, heading, x, y, z; and "up" if the pose is upside down. kDoubtful: the axis
  /// was not moved enough, or the pose does not show its motion. If no axis is wrong: "lever arm".
  std::vector<CheckResult> checks() const;
  std::size_t samples() const { return samples_; }

 private:
  static constexpr std::size_t kSpan = 20;  ///< h of the second difference and of a turn, in samples: 0.2 s

  void add_tilt(const Sample& sample);
  void add_turn(const Sample& then, const Sample& now);
  void add_position();
  void add_lever_arm(const Sample& sample);
  CheckResult lever_arm_check() const;

  std::deque<Sample> window_;  ///< the newest 2 kSpan + 1 samples
  std::size_t samples_ = 0;
  // Sums of products. Rows are the pose's axes, columns the autopilot's; checks() subtracts the means.
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
  struct {
    est::Estimate<double> motion;  ///< of the poses
    est::VelocityConsistency<double> consistency;
    est::LeverArmFit<double> fit;  ///< when it had turned most
  } lever_arm_;
};

}  // namespace m100::companion::preflight
