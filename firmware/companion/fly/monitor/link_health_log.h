// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/companion/operator/link_report.h"
#include "firmware/core/time.h"
#include "firmware/est/consistency_status.h"
#include "firmware/log/flight_log.h"

namespace m100::companion {

/// Logs the health of the link and the vibration once a second.
class LinkHealthLog {
 public:
  explicit LinkHealthLog(log::FlightLogWriter* log) : log_(log) {}
  void tick(core::TimePoint now, const link::LinkHealth& health, const est::VibrationStatus& vibration) {
    if (log_ != nullptr && now - logged_at_ >= kPeriod) {
      log_->append(now, health_line(health, text_));
      log_->append(log::VibrationRecord{.timestamp = static_cast<std::uint64_t>(now.time_since_epoch().count()),
                                        .rms = static_cast<float>(vibration.rms_m_s2),
                                        .peak = static_cast<float>(vibration.peak_m_s2),
                                        .clipped = static_cast<float>(vibration.clipped),
                                        .velocity_sigma = static_cast<float>(vibration.velocity_sigma_m_s)});
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
