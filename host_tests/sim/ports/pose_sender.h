// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <span>

#include "hal/uart.h"
#include "host_tests/sim/world/pose_source.h"
#include "host_tests/sim/world/vehicle.h"
#include "protocol/mavlink/parser.h"

namespace m100::sim {

/// The motion capture beside the autopilot: what `m100 fly --pose-port` reads by default, on a line of its own.
/// ATT_POS_MOCAP without its covariance, 48 bytes a pose; it answers TIMESYNC where the plant says so.
class PoseSender {
 public:
  PoseSender(hal::Uart& uart, const Plant& plant, std::uint64_t seed) : uart_(uart), source_(plant.pose, seed) {}

  /// Sends what has arrived by now. A line that is full loses it.
  /// @param moved_at until when the aircraft has moved.
  void step(core::TimePoint now, const Vehicle& vehicle, core::TimePoint moved_at);
  /// Earlier than this there is nothing to do.
  core::TimePoint next_event() const { return source_.next_event(); }
  PoseSource& source() { return source_; }
  /// When the newest of all poses was taken whose last byte has passed the line by now; at first: when our clock began.
  core::TimePoint newest_captured(core::TimePoint now);

 private:
  /// A pose on the line, which is full at 240 poses a second: they wait for each other.
  struct OnLine {
    core::TimePoint passed{};
    core::TimePoint captured{};
  };
  /// A question on its way to the source, and back as its answer.
  struct Question {
    std::int64_t ts1 = 0;
    core::TimePoint heard{};
    core::TimePoint answered{};
  };
  void answer_questions(core::TimePoint now);
  /// @returns when the last of these bytes has passed; nothing: not all of them fitted.
  std::optional<core::TimePoint> send(std::span<const std::byte> bytes, core::TimePoint now);

  hal::Uart& uart_;
  PoseSource source_;
  mavlink::Parser parser_;
  std::deque<Question> questions_;
  std::deque<OnLine> on_line_;
  std::int64_t line_free_ns_ = 0;
  core::TimePoint newest_captured_{};
  std::uint8_t frames_ = 0;
};

}  // namespace m100::sim
