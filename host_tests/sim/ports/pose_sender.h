// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <span>

#include "hal/uart.h"
#include "host_tests/sim/world/pose_source.h"
#include "host_tests/sim/world/vehicle_port.h"
#include "protocol/mavlink/parser.h"

namespace m100::sim {

/// Sends the poses of the motion capture on its own line, in the default format of `m100 fly --pose-port`:
/// ATT_POS_MOCAP without its covariance, 48 bytes per pose. It answers TIMESYNC if the plant says so.
class PoseSender {
 public:
  PoseSender(hal::Uart& uart, const Plant& plant, std::uint64_t seed) : uart_(uart), source_(plant.pose, seed) {}

  /// Sends the poses that have arrived by now. A full line loses them.
  /// @param moved_at the time up to which the aircraft has moved.
  void step(core::TimePoint now, const VehiclePort& vehicle, core::TimePoint moved_at);
  /// Time of the next event of the pose source.
  core::TimePoint next_event() const { return source_.next_event(); }
  PoseSource& source() { return source_; }
  /// Time of capture of the newest pose whose last byte has passed the line by now; initially the start of our clock.
  core::TimePoint newest_captured(core::TimePoint now);

 private:
  /// A pose on the line. The line is full at 240 poses a second, so poses wait for each other.
  struct OnLine {
    core::TimePoint passed{};
    core::TimePoint captured{};
  };
  /// A time request on its way to the source, or its answer on the way back.
  struct TimeRequest {
    std::int64_t ts1 = 0;
    core::TimePoint received{};
    core::TimePoint answered{};
  };
  void answer_time_requests(core::TimePoint now);
  /// @returns the time at which the last of these bytes has passed; nothing: not all of them fitted.
  std::optional<core::TimePoint> send(std::span<const std::byte> bytes, core::TimePoint now);

  hal::Uart& uart_;
  PoseSource source_;
  mavlink::Parser parser_;
  std::deque<TimeRequest> requests_;
  std::deque<OnLine> on_line_;
  std::int64_t line_free_ns_ = 0;
  core::TimePoint newest_captured_{};
  std::uint8_t frames_ = 0;
};

}  // namespace m100::sim
