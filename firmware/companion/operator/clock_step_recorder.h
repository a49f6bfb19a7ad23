// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/companion/operator/operator_log.h"
#include "firmware/est/timing/pose_timing.h"

namespace m100::companion {

/// A setting or slew of the pose source's clock: when it began, its sum, and how long it lasted.
struct ClockStep {
  core::TimePoint at{};
  core::Duration by{0};
  core::Duration lasted{0};
};

/// Reports when the clock of the source of pose was set, or when its poses come later and it is unknown whether the
/// clock or the transport changed. A slew, which is a series of small steps, counts as one step. No heap.
class ClockStepRecorder {
 public:
  static constexpr std::size_t kMaxSteps = 32;  ///< that are kept

  /// Call it after each tick.
  void update(core::TimePoint now, const est::PoseTimingReport<double>& timing, OperatorLog& log);
  std::span<const ClockStep> steps() const { return std::span(steps_).first(step_count_); }

 private:
  core::Duration set_by_{0};  ///< PoseTimingReport's, at the last step
  std::uint32_t times_set_ = 0;
  ClockStep step_;
  bool step_is_open_ = false;
  bool later_said_ = false;
  core::TimePoint stepped_at_{};
  std::array<ClockStep, kMaxSteps> steps_{};
  std::size_t step_count_ = 0;
};

}  // namespace m100::companion
