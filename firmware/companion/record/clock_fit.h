// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

#include "firmware/core/time.h"

namespace m100::companion {

/// Lays the autopilot's clock on ours. What arrives has waited on its way, now longer, now shorter; the stamps inside
/// have not. The offset between the clocks is the least that was seen, and may grow as fast as two crystals drift
/// apart, so that stamps keep the spacing that they were made with.
class ClockFit {
 public:
  /// @param own what the package says of its time. @param arrived when it came.
  /// @returns when it was made, as far as the quickest way tells; never after `arrived`, never before the one before.
  core::TimePoint lay(core::Duration own, core::TimePoint arrived) {
    const core::Duration offset = arrived.time_since_epoch() - own;
    if (offset_ && std::max(offset - *offset_, *offset_ - offset) > kJump) {
      offset_.reset();
      ++restarts_;
    }
    const core::Duration drift = (arrived - last_arrived_) / kDriftShare;
    offset_ = offset_ ? std::min(offset, *offset_ + drift) : offset;
    last_arrived_ = arrived;
    last_ = std::max(last_, core::TimePoint{own + *offset_});
    return last_;
  }
  /// Jumps of more than a second: the autopilot began anew.
  std::uint32_t restarts() const { return restarts_; }

 private:
  static constexpr core::Duration kJump = std::chrono::seconds(1);
  static constexpr int kDriftShare = 5000;  ///< 200 ppm: two crystals of 100 ppm

  std::optional<core::Duration> offset_;
  core::TimePoint last_arrived_{};
  core::TimePoint last_{};
  std::uint32_t restarts_ = 0;
};

}  // namespace m100::companion
