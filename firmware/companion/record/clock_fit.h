// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

#include "firmware/core/time.h"

namespace m100::companion {

/// Converts time stamps of another clock (the autopilot's, the pose sender's) to ours. Arrival times have a jitter; the
/// time stamps have none. The offset between the clocks is the smallest one seen, and may grow as fast as two crystals
/// drift apart. So the converted time stamps nearly keep their original spacing.
class ClockFit {
 public:
  /// @param own time stamp, by the other clock. @param arrived its arrival on our clock.
  /// @returns the time of the stamp on our clock, with the shortest delay seen taken as zero; not after `arrived`, and
  ///   never before the last result.
  core::TimePoint to_our_clock(core::Duration own, core::TimePoint arrived) {
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
  /// Number of jumps of more than a second: the other side restarted, or its clock was set.
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
