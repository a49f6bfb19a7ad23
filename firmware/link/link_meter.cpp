// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/link/link_meter.h"

#include <algorithm>

namespace m100::link {
namespace {

constexpr core::Duration kWindow = std::chrono::seconds(1);
constexpr double kBitsPerByte = 10.0;
/// Bounds of the adapter delay: the least of a UART, and more than any adapter has (a USB one waits 16 ms by default).
constexpr core::Duration kMinAdapterDelay = std::chrono::milliseconds(2);
constexpr core::Duration kMaxAdapterDelay = std::chrono::milliseconds(40);

std::size_t bin_of(core::Duration jitter) {
  std::size_t bin = 0;
  while (bin < LinkHealth::kJitterBins_us.size() && jitter.count() >= LinkHealth::kJitterBins_us[bin]) {
    ++bin;
  }
  return bin;
}

}  // namespace

void LinkMeter::received(std::size_t bytes) {
  health_.bytes_received += bytes;
  window_received_ += bytes;
}

void LinkMeter::sent(std::size_t bytes) {
  health_.bytes_sent += bytes;
  window_sent_ += bytes;
}

void LinkMeter::package(core::TimePoint now) {
  if (has_package_) {
    health_.longest_gap = std::max(health_.longest_gap, now - last_package_);
  }
  has_package_ = true;
  last_package_ = now;
  ++health_.packages;
  ++window_packages_;
}

void LinkMeter::timed_package(core::TimePoint now, core::Duration autopilot_time) {
  const core::Duration offset = now.time_since_epoch() - autopilot_time;
  if (has_time_) {
    const core::Duration jitter = (now - last_timed_) - (autopilot_time - last_autopilot_time_);
    ++health_.jitter_histogram[bin_of(std::chrono::abs(jitter))];
    // The clocks drift apart, so the least offset may grow by 100 parts per million of the time.
    min_offset_ = std::min(offset, min_offset_ + (now - last_timed_) / 10000);
  } else {
    min_offset_ = offset;
  }
  health_.transport_delay = offset - min_offset_;
  window_delay_ = std::max(window_delay_, health_.transport_delay);
  has_time_ = true;
  last_timed_ = now;
  last_autopilot_time_ = autopilot_time;
}

void LinkMeter::restart() {
  has_time_ = false;
  ++health_.restarts;
}

core::Duration LinkMeter::adapter_delay() const {
  const core::Duration longest = std::max(window_delay_, former_delay_);
  return has_time_ ? std::clamp(longest, kMinAdapterDelay, kMaxAdapterDelay) : kMaxAdapterDelay;
}

void LinkMeter::tick(core::TimePoint now) {
  health_.telemetry_age = has_package_ ? now - last_package_ : core::Duration{0};
  const core::Duration elapsed = now - window_start_;
  if (elapsed < kWindow) {
    return;
  }
  const double elapsed_s = core::seconds<double>(elapsed);
  const double line_bytes = static_cast<double>(baud_) / kBitsPerByte * elapsed_s;
  health_.telemetry_rate_hz = window_packages_ / elapsed_s;
  health_.receive_share = static_cast<double>(window_received_) / line_bytes;
  health_.send_share = static_cast<double>(window_sent_) / line_bytes;
  window_start_ = now;
  window_received_ = 0;
  window_sent_ = 0;
  window_packages_ = 0;
  former_delay_ = window_delay_;
  window_delay_ = core::Duration{0};
}

}  // namespace m100::link
