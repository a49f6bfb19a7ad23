// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/companion/fly/monitor/thread_accounting.h"
#include "firmware/companion/operator/operator_log.h"

namespace m100::companion {

/// Says why this program stood still for longer than kReportedStall, by what the kernel counted since the tick before.
class StallMonitor {
 public:
  /// Five periods between two ticks: more than a healthy flight ever has.
  static constexpr core::Duration kReportedStall = 5 * core::kTickPeriod;

  explicit StallMonitor(OperatorLog& operator_log) : operator_log_(operator_log) {}

  /// Call it at the beginning of each tick. No heap.
  void tick(core::TimePoint now) {
    const ThreadCounts counts = accounting_.update();
    if (last_ != core::TimePoint{} && now - last_ > kReportedStall) {
      operator_log_.write(now, describe(now - last_, counts).text());
    }
    last_ = now;
  }

 private:
  OperatorLog& operator_log_;
  ThreadAccounting accounting_;
  core::TimePoint last_{};
};

}  // namespace m100::companion
