// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/app/tick_record.h"
#include "firmware/companion/operator/link_report.h"
#include "firmware/log/flight_log.h"

namespace m100::companion {

/// Logs the health of the link and the vibration once a second.
class LinkHealthLog {
 public:
  explicit LinkHealthLog(log::FlightLogWriter* log) : log_(log) {}
  void tick(const app::TickRecord<double>& record) {
    if (log_ != nullptr && record.now - logged_at_ >= kPeriod) {
      const est::VibrationStatus& vibration = record.seen.consistency.vibration;
      log_->append(record.now, health_line(record.health, text_));
      log_->append(log::VibrationRecord{.timestamp = static_cast<std::uint64_t>(record.now.time_since_epoch().count()),
                                        .rms = static_cast<float>(vibration.rms_m_s2),
                                        .peak = static_cast<float>(vibration.peak_m_s2),
                                        .clipped = static_cast<float>(vibration.clipped),
                                        .velocity_sigma = static_cast<float>(vibration.velocity_sigma_m_s)});
      logged_at_ = record.now;
    }
  }

 private:
  log::FlightLogWriter* log_;
  static constexpr core::Duration kPeriod = std::chrono::seconds(1);

  core::TimePoint logged_at_{};
  HealthText text_{};
};

}  // namespace m100::companion
