// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/companion/operator/link_report.h"
#include "firmware/core/time.h"
#include "firmware/log/flight_log.h"

namespace m100::companion {

/// Logs the health of the link once a second.
class LinkHealthLog {
 public:
  explicit LinkHealthLog(log::FlightLogWriter* log) : log_(log) {}
  void tick(core::TimePoint now, const link::LinkHealth& health) {
    if (log_ != nullptr && now - logged_at_ >= kPeriod) {
      log_->append(now, health_line(health, text_));
      logged_at_ = now;
    }
  }

 private:
  log::FlightLogWriter* log_;
  static constexpr core::Duration kPeriod = std::chrono::seconds(1);

  core::TimePoint logged_at_{};
  HealthText text_{};
};

}  // namespace m100::companion
