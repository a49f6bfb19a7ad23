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
#include "protocol/dji/frame_parser.h"
#include "protocol/mavlink/parser.h"
#include "protocol/mavlink/pose_messages.h"

namespace m100::authority {

/// The faults of one direction of a line, in any combination.
struct StreamFaultPlan {
  bool cut = false;      ///< nothing passes
  double drop = 0.0;     ///< share of the pieces (bytes of one write) that vanish
  double twice = 0.0;    ///< share of the pieces that arrive twice
  double swapped = 0.0;  ///< share of the pieces that arrive after the next one
  double flip_per_bit = 0.0;
  core::Duration delay{0};
  core::Duration jitter{0};   ///< added to delay, drawn for each piece; the order stays
  core::Duration bunch{0};    ///< pieces of each such interval pass together at its end; 0: at once
  std::uint32_t sent_at = 0;  ///< baud; with received_at: re-sampled as between UARTs of different rates
  std::uint32_t received_at = 0;
  std::size_t swallow = 0;                  ///< number of bytes that vanish once, which cuts frames short
  bool telemetry_stands_still = false;      ///< every telemetry frame is replaced by the first one
  core::Duration telemetry_again_after{0};  ///< every telemetry frame is repeated after this time; 0: it is not
  bool in_fragments = false;                ///< each piece arrives in fragments of 1 to 16 bytes, up to 1 ms apart
  bool strange_answers = false;             ///< before each answer arrives a copy that belongs to another session
};

/// One direction of the man in the middle: delays and changes bytes.
class StreamFaultInjector {
 public:
  explicit StreamFaultInjector(std::uint64_t seed) : random_(seed, "tamper") {}

  StreamFaultPlan plan;
  /// Takes the bytes of one read of the line.
  void take(std::span<const std::byte> bytes, core::TimePoint now);
  /// Inserts bytes of our own before the next ones.
  void inject(std::span<const std::byte> bytes, core::TimePoint now) { queue(bytes, now); }
  /// @returns the bytes that are due by now.
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

/// The same for poses, message by message: `change` may alter or drop a message.
class PoseFaultInjector {
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

}  // namespace m100::authority
