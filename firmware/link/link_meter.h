// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/time.h"
#include "firmware/link/link_health.h"

namespace m100::link {

/// Computes LinkHealth from the traffic of a link.
class LinkMeter {
 public:
  explicit LinkMeter(std::uint32_t baud) : baud_(baud) {}

  void received(std::size_t bytes);
  void sent(std::size_t bytes);
  /// A new telemetry package with the autopilot's clock that did not wait in the parser.
  void timed_package(core::TimePoint now, core::Duration autopilot_time);
  /// Any new telemetry package.
  void package(core::TimePoint now);
  /// The autopilot's clock is a new one.
  void restart();
  /// Once per tick: rates, shares, ages.
  void tick(core::TimePoint now);

  LinkHealth& counters() { return health_; }
  const LinkHealth& health() const { return health_; }
  /// Longest transport delay of a package in the last one or two seconds, limited to 2..40 ms; 40 ms if unknown.
  core::Duration adapter_delay() const;

 private:
  std::uint32_t baud_;
  LinkHealth health_;
  core::TimePoint window_start_{};
  std::uint64_t window_received_ = 0;
  std::uint64_t window_sent_ = 0;
  std::uint32_t window_packages_ = 0;
  bool has_package_ = false;
  core::TimePoint last_package_{};
  bool has_time_ = false;
  core::TimePoint last_timed_{};
  core::Duration last_autopilot_time_{0};
  core::Duration window_delay_{0};  ///< longest transport delay of this second; former_delay_: of the one before
  core::Duration former_delay_{0};
  core::Duration min_offset_{0};  ///< arrival by our clock minus the autopilot's time, for the fastest package
};

}  // namespace m100::link
