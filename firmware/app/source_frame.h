// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "firmware/core/fence.h"
#include "firmware/core/frames.h"
#include "firmware/core/pose.h"
#include "firmware/est/estimate.h"

namespace m100::app {

/// A jump of the pose source's world that the source announced by its reset_counter.
struct AnnouncedJump {
  std::uint32_t count = 0;       ///< of all so far
  std::array<double, 3> by_m{};  ///< the last one, in the world
  double turned_rad = 0.0;       ///< 0: the heading stayed
};

/// The world of the pose source, seen from that of the flight, in which the source began. An announced jump (a loop
/// closure, a relocalisation) moves the source's world by what the pose differs from the prediction, so estimate and
/// reference keep their motion, and the aircraft does not move by the jump.
///
/// An announcement counts if the prediction is valid and the poses have followed it for 0.3 s since the jump before;
/// otherwise its pose is judged like any other. A turn below 0.05 rad (the error of a heading by 30 ms of a wrong time
/// of capture at 1.75 rad/s) is left to the observer.
///
/// No heap. Cost of a tick without a rotation: six products. T is float or double.
template <typename T>
class SourceFrame {
 public:
  /// Brings a new pose into the flight's world. @param announced jumps that the link has counted. @param latency of the
  /// poses. @returns whether the source's world has moved.
  bool update(core::Pose<T>& pose, std::uint32_t announced, const est::Estimate<T>& estimate, core::Duration latency,
              core::TimePoint now) {
    const bool is_announced = announced != announced_;
    announced_ = announced;
    const bool follows = now - moved_at_ >= kFollowedFor && estimate.refused_poses == 0;
    const bool moves = is_announced && follows && estimate.healthy && estimate.prediction_valid;
    if (moves) {
      move(pose, estimate, core::seconds<T>(latency - core::kTickPeriod));
      moved_at_ = now;
    }
    pose.position_w_m = to_flight(pose.position_w_m);
    pose.yaw_rad = core::wrap_pi(pose.yaw_rad + turn_rad_);
    return moves;
  }

  core::Vector<T, 3> to_flight(const core::Vector<T, 3>& source_m) const { return rotated(source_m, turn_) + shift_m_; }
  core::Vector<T, 3> to_source(const core::Vector<T, 3>& flight_m) const {
    return rotated(flight_m - shift_m_, {.sine = -turn_.sine, .cosine = turn_.cosine});
  }
  T turn_rad() const { return turn_rad_; }
  const AnnouncedJump& jump() const { return jump_; }

  /// The box of the largest area, along the axes of the flight's world, inside the fence that stands in the source's.
  [[gnu::cold]] core::Fence moved(const core::Fence& fence) const {
    core::Vector<double, 3> middle_m, half_m;
    for (std::size_t axis = 0; axis < fence.side.size(); ++axis) {
      const auto at = static_cast<Eigen::Index>(axis);
      middle_m[at] = 0.5 * (fence.side[axis].low_m + fence.side[axis].high_m);
      half_m[at] = 0.5 * (fence.side[axis].high_m - fence.side[axis].low_m);
    }
    half_m.template head<2>() = inscribed(half_m.x(), half_m.y());
    middle_m = to_flight(middle_m.template cast<T>()).template cast<double>();
    core::Fence box = fence;
    for (std::size_t axis = 0; axis < box.side.size(); ++axis) {
      const auto at = static_cast<Eigen::Index>(axis);
      box.side[axis] = {.low_m = middle_m[at] - half_m[at], .high_m = middle_m[at] + half_m[at]};
    }
    return box;
  }

 private:
  static constexpr core::Duration kFollowedFor = std::chrono::milliseconds(300);
  static constexpr double kSmallestTurn_rad = 0.05;

  static double absolute(double value) { return value < 0.0 ? -value : value; }
  /// Half the sides (a, b) of the rectangle of the largest area inside one of half the sides x and y that is turned by
  /// turn_rad_: a c + b s <= x and a s + b c <= y. Either both bound it, or the shorter side alone.
  core::Vector<double, 2> inscribed(double x, double y) const {
    const double c = absolute(static_cast<double>(turn_.cosine)), s = absolute(static_cast<double>(turn_.sine));
    const double shorter = x < y ? x : y, longer = x < y ? y : x;
    const double apart = absolute(c * c - s * s);
    if (shorter <= 2.0 * s * c * longer || apart < 1e-9) {
      const double by_cosine = 0.5 * shorter / c, by_sine = 0.5 * shorter / s;
      return x < y ? core::Vector<double, 2>(by_cosine, by_sine) : core::Vector<double, 2>(by_sine, by_cosine);
    }
    return {absolute(x * c - y * s) / apart, absolute(y * c - x * s) / apart};
  }
  static core::Vector<T, 3> rotated(const core::Vector<T, 3>& v, const core::SinCos<T>& turn) {
    const core::Vector<T, 2> level = core::rotate<T>({v.x(), v.y()}, turn);
    return {level.x(), level.y(), v.z()};
  }

  /// @param latency_s from the capture to the estimate, which is that of the tick before.
  [[gnu::noinline]] void move(const core::Pose<T>& pose, const est::Estimate<T>& estimate, T latency_s) {
    const core::Vector<T, 3> predicted_m(estimate.x.position_m - latency_s * estimate.x.velocity_m_s,
                                         estimate.y.position_m - latency_s * estimate.y.velocity_m_s,
                                         estimate.height_m - latency_s * estimate.climb_m_s);
    const core::Vector<T, 3> by_m = to_flight(pose.position_w_m) - predicted_m;
    const T turned_rad =
        core::wrap_pi(pose.yaw_rad + turn_rad_ - (estimate.yaw_rad - latency_s * estimate.yaw_rate_rad_s));
    const bool turns = absolute(static_cast<double>(turned_rad)) >= kSmallestTurn_rad;
    if (turns) {
      turn_rad_ = core::wrap_pi(turn_rad_ - turned_rad);
      turn_ = core::sin_cos_of(turn_rad_);
    }
    shift_m_ = predicted_m - rotated(pose.position_w_m, turn_);
    jump_ = {.count = jump_.count + 1,
             .by_m = {static_cast<double>(by_m.x()), static_cast<double>(by_m.y()), static_cast<double>(by_m.z())},
             .turned_rad = turns ? static_cast<double>(turned_rad) : 0.0};
  }

  core::Vector<T, 3> shift_m_ = core::Vector<T, 3>::Zero();
  T turn_rad_{0};
  core::SinCos<T> turn_;
  std::uint32_t announced_ = 0;
  core::TimePoint moved_at_{-kFollowedFor};
  AnnouncedJump jump_;
};

}  // namespace m100::app
