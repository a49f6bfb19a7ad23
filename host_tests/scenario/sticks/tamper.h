// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <span>
#include <vector>

#include "firmware/core/time.h"
#include "host_tests/sim/world/random.h"
#include "protocol/frame_parser.h"
#include "protocol/mavlink/parser.h"
#include "protocol/mavlink/pose_messages.h"

namespace m100::sticks {

/// What is done to one direction of a line. All of it may be on at once.
struct TamperPlan {
  bool cut = false;      ///< nothing passes
  double drop = 0.0;     ///< share of the pieces (what was written at a time) that vanish
  double twice = 0.0;    ///< share of the pieces that come twice
  double swapped = 0.0;  ///< share of the pieces that come after the one behind them
  double flip_per_bit = 0.0;
  core::Duration delay{0};
  core::Duration jitter{0};   ///< on top, drawn for each piece; the order stays
  core::Duration bunch{0};    ///< what comes in so long a time passes at its end; 0: at once
  std::uint32_t sent_at = 0;  ///< baud; with received_at: re-sampled as between two UARTs that differ
  std::uint32_t received_at = 0;
  std::size_t swallow = 0;                  ///< bytes that vanish, once: the frames they belong to are cut short
  bool telemetry_stands_still = false;      ///< instead of every telemetry frame the first one comes once more
  core::Duration telemetry_again_after{0};  ///< every telemetry frame comes once more, so much later; 0: it does not
  bool in_fragments = false;                ///< each piece comes in fragments of 1 to 16 bytes, up to 1 ms apart
  bool strange_answers = false;             ///< in front of each answer comes another of the session behind its own
};

/// One direction of the man in the middle: bytes in, bytes out at their times.
class Tamper {
 public:
  explicit Tamper(std::uint64_t seed) : random_(seed, "tamper") {}

  TamperPlan plan;
  /// Bytes of one visit of the line.
  void take(std::span<const std::byte> bytes, core::TimePoint now);
  /// Bytes of our own, in front of whatever comes next.
  void inject(std::span<const std::byte> bytes, core::TimePoint now) { queue(bytes, now); }
  /// What must have arrived by now.
  std::vector<std::byte> due(core::TimePoint now);

 private:
  struct Piece {
    core::TimePoint when;
    std::vector<std::byte> bytes;
  };
  void flip_bits(std::span<std::byte> piece);
  void queue(std::span<const std::byte> bytes, core::TimePoint now);
  void queue_frames(std::span<const std::byte> bytes, core::TimePoint now);
  void queue_fragments(std::span<const std::byte> bytes, core::TimePoint now);

  sim::Random random_;
  std::deque<Piece> pieces_;
  std::deque<Piece> again_;
  protocol::FrameParser parser_;
  std::vector<std::byte> standing_;
  std::vector<std::byte> held_back_;
};

/// The same for poses, message by message: `change` may alter a message or refuse it.
class PoseTamper {
 public:
  using Change = std::function<bool(mavlink::AttPosMocap& message, core::TimePoint now)>;  ///< @returns false: drop it
  void set_change(Change change) { change_ = std::move(change); }
  std::vector<std::byte> pass(std::span<const std::byte> bytes, core::TimePoint now);

 private:
  Change change_;
  mavlink::Parser parser_;
};

/// A header with a valid CRC16 that announces a frame of 1023 bytes, which never comes.
std::vector<std::byte> false_header();

}  // namespace m100::sticks
