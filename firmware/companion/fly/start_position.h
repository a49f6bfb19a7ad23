// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

#include "firmware/core/maths.h"
#include "firmware/core/pose.h"
#include "firmware/ref/trajectory.h"

namespace m100::companion {

/// Where the aircraft stands before a flight, from poses that agree. The course and the fence are laid from this place,
/// so one wrong pose must not define it. Of nine successive poses, more than half must lie within 0.3 m of their
/// median; until they do, later poses replace the oldest. The result is the pose nearest to the median among those
/// whose heading agrees with the others'.
class StartPosition {
 public:
  /// @returns the place, as soon as enough poses agree.
  std::optional<ref::Waypoint<double>> add(const core::Pose<double>& pose) {
    last_[seen_++ % last_.size()] = pose;
    if (seen_ < last_.size()) {
      return std::nullopt;
    }
    const core::Vector<double, 3> middle = median_place();
    const auto off_m = [&](const core::Pose<double>& one) { return (one.position_w_m - middle).norm(); };
    const auto agree = std::count_if(last_.begin(), last_.end(), [&](const auto& one) { return off_m(one) < kNear_m; });
    if (2 * static_cast<std::size_t>(agree) <= kPoses) {
      return std::nullopt;
    }
    // The sum of the angles between this heading and those of the poses near the median.
    const auto turned_rad = [&](const core::Pose<double>& one) {
      double sum = 0.0;
      for (const core::Pose<double>& other : last_) {
        sum += off_m(other) < kNear_m ? std::abs(core::wrap_pi(other.yaw_rad - one.yaw_rad)) : 0.0;
      }
      return sum;
    };
    const auto least = [&](const auto& measure, const auto& counts) -> const core::Pose<double>& {
      const core::Pose<double>* best = &last_.front();
      for (const core::Pose<double>& one : last_) {  // more than half agree, so one counts
        best = counts(one) && (!counts(*best) || measure(one) < measure(*best)) ? &one : best;
      }
      return *best;
    };
    const double yaw_rad = least(turned_rad, [&](const auto& one) { return off_m(one) < kNear_m; }).yaw_rad;
    const core::Pose<double>& nearest = least(off_m, [&](const core::Pose<double>& one) {
      return off_m(one) < kNear_m && std::abs(core::wrap_pi(one.yaw_rad - yaw_rad)) < kNear_rad;
    });
    ref::Waypoint<double> start;
    start.position_w_m = nearest.position_w_m;
    start.yaw_rad = nearest.yaw_rad;
    return start;
  }

  static constexpr std::size_t kPoses = 9;  ///< number of poses that are compared
  /// The number of poses so far.
  std::size_t poses() const { return seen_; }
  /// Enough poses came, but did not agree.
  bool disagrees() const { return seen_ >= kPoses; }

 private:
  core::Vector<double, 3> median_place() const {
    core::Vector<double, 3> middle;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      std::array<double, kPoses> values{};
      std::transform(last_.begin(), last_.end(), values.begin(),
                     [&](const core::Pose<double>& one) { return one.position_w_m[axis]; });
      std::nth_element(values.begin(), values.begin() + kPoses / 2, values.end());
      middle[axis] = values[kPoses / 2];
    }
    return middle;
  }

  static constexpr double kNear_m = 0.3;
  static constexpr double kNear_rad = 0.35;  ///< the observer's gate

  std::array<core::Pose<double>, kPoses> last_{};
  std::size_t seen_ = 0;
};

}  // namespace m100::companion
