// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "firmware/core/pose.h"
#include "firmware/link/pose/pose_fault.h"

namespace m100::link {

/// Detects time stamps that are not microseconds, by how fast they advance compared with the arrivals. Two successive
/// windows must agree, because one may hold a step of the sender's clock. Nanoseconds run 1000 times too fast,
/// milliseconds 1000 times too slowly; the limit is a factor of 30, about the root of 1000.
class StampUnit {
 public:
  static constexpr core::Duration kWindow = std::chrono::milliseconds(300);  ///< nine poses of 30 Hz

  PoseFault judge(core::SenderTime stamp, core::TimePoint now) {
    if (poses_ == 0) {
      begin(stamp, now);
      return fault_;
    }
    ++poses_;
    const core::Duration elapsed = now - since_;
    if (elapsed < kWindow || poses_ < kFewest) {
      return fault_;
    }
    const std::int64_t advance = (stamp - first_).count();
    const std::int64_t distance = advance < 0 ? -advance : advance;
    const PoseFault seen = distance / kFactor > elapsed.count()   ? PoseFault::kFastStamp
                           : elapsed.count() / kFactor > distance ? PoseFault::kSlowStamp
                                                                  : PoseFault::kNone;
    fault_ = seen == last_seen_ ? seen : PoseFault::kNone;
    last_seen_ = seen;
    begin(stamp, now);
    return fault_;
  }

 private:
  static constexpr std::int64_t kFactor = 30;
  static constexpr std::uint32_t kFewest = 4;  ///< poses in a window

  void begin(core::SenderTime stamp, core::TimePoint now) {
    first_ = stamp;
    since_ = now;
    poses_ = 1;
  }

  core::SenderTime first_{};
  core::TimePoint since_{};
  std::uint32_t poses_ = 0;
  PoseFault last_seen_ = PoseFault::kNone;
  PoseFault fault_ = PoseFault::kNone;
};

}  // namespace m100::link
