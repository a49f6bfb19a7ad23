// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>

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

 private:
  /// A question on its way to the source, and back as its answer.
  struct Question {
    std::int64_t ts1 = 0;
    core::TimePoint heard{};
    core::TimePoint answered{};
  };
  void answer_questions(core::TimePoint now);

  hal::Uart& uart_;
  PoseSource source_;
  mavlink::Parser parser_;
  std::deque<Question> questions_;
  std::uint8_t frames_ = 0;
};

}  // namespace m100::sim
