// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>

#include "firmware/core/pose.h"
#include "firmware/ref/trajectory.h"

namespace m100::companion {

/// Where the aircraft stands before a flight, from poses that agree. The course and the fence are laid from this place,
/// so one wrong pose must not become it: nine poses in a row are asked, more than half of which lie within 0.3 m of
/// their median (what a pilot lets an aircraft wander at 1 m/s while a source of 30 Hz sends nine), and the one nearest
/// to the median is taken. Poses that do not agree are followed by others.
class StartPlace {
 public:
  /// @returns the place, as soon as it is sure.
  std::optional<ref::Waypoint<double>> add(const core::Pose<double>& pose) {
    last_[seen_++ % last_.size()] = pose;
    if (seen_ < last_.size()) {
      return std::nullopt;
    }
    core::Vector<double, 3> middle;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      std::array<double, kPoses> values{};
      std::transform(last_.begin(), last_.end(), values.begin(),
                     [&](const core::Pose<double>& one) { return one.position_w_m[axis]; });
      std::nth_element(values.begin(), values.begin() + kPoses / 2, values.end());
      middle[axis] = values[kPoses / 2];
    }
    const auto off_m = [&](const core::Pose<double>& one) { return (one.position_w_m - middle).norm(); };
    const auto agree = std::count_if(last_.begin(), last_.end(), [&](const auto& one) { return off_m(one) < kNear_m; });
    if (2 * static_cast<std::size_t>(agree) <= kPoses) {
      return std::nullopt;
    }
    const core::Pose<double>& nearest = *std::min_element(
        last_.begin(), last_.end(), [&](const auto& a, const auto& b) { return off_m(a) < off_m(b); });
    ref::Waypoint<double> start;
    start.position_w_m = nearest.position_w_m;
    start.yaw_rad = nearest.yaw_rad;
    return start;
  }

  /// Poses came, and did not agree.
  bool disagrees() const { return seen_ >= kPoses; }

 private:
  static constexpr std::size_t kPoses = 9;
  static constexpr double kNear_m = 0.3;

  std::array<core::Pose<double>, kPoses> last_{};
  std::size_t seen_ = 0;
};

}  // namespace m100::companion
