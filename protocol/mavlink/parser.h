// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/core/expected.h"
#include "protocol/mavlink/frame.h"

namespace m100::mavlink {

/// What the parser has met.
struct ParserStats {
  std::uint64_t bytes = 0;         ///< taken
  std::uint64_t frames = 0;        ///< delivered
  std::uint64_t crc_errors = 0;    ///< a header of a known message, but the checksum fails
  std::uint64_t unknown = 0;       ///< where a frame was due: a message whose checksum we do not know
  std::uint64_t incompatible = 0;  ///< where a frame was due: a flag that we do not know, so the frame must not be read
  std::uint64_t bytes_dropped = 0;  ///< belong to no delivered frame
};

/// Finds frames of MAVLink 1 and 2 in a byte stream that may start anywhere and may be damaged anywhere.
///
/// Invariants, whatever the bytes are: at most kBufferBytes are stored; no frame is reported unless its checksum holds;
/// a stretch that proves to be no frame is searched again from its second byte, so that a good frame inside it, or
/// right behind it, is found. A message that we do not know has a checksum that we cannot check: it is not believed to
/// be a frame, and its bytes are searched like any others.
///
/// Cost: each start byte whose header is one of a known message costs one checksum of what the header claims, 270 bytes
/// at most; every other byte a comparison.
class Parser {
 public:
  static constexpr std::size_t kBufferBytes = 512;
  static_assert(kBufferBytes > kMostFrameBytes, "there must be room for a byte whenever no frame is complete");

  /// Takes bytes, as many as there is room for, at least one after poll() said kNotReady. Views of earlier frames end
  /// here. @returns the number of bytes taken.
  [[nodiscard]] std::size_t push(std::span<const std::byte> bytes);

  /// The next frame. It views the parser's buffer until the next push(). @returns kNotReady: none is complete yet.
  core::Expected<FrameView> poll();

  /// Feeds all bytes and calls on_frame(const FrameView&) for each frame found.
  template <typename OnFrame>
  void consume(std::span<const std::byte> bytes, OnFrame&& on_frame) {
    while (!bytes.empty()) {
      bytes = bytes.subspan(push(bytes));
      for (core::Expected<FrameView> frame = poll(); frame; frame = poll()) {
        on_frame(*frame);
      }
    }
  }

  /// Forgets what has begun: the next byte begins a packet of a network, not the rest of the one before.
  void begin_packet();

  const ParserStats& stats() const { return stats_; }

 private:
  /// What the bytes at the window's begin are.
  enum class Verdict : std::uint8_t { kNoFrame, kTooShort, kFrame };
  struct Judgement {
    Verdict verdict = Verdict::kNoFrame;
    FrameView frame;
  };
  Judgement judge(std::span<const std::byte> bytes);
  Judgement judge_2(std::span<const std::byte> bytes);
  Judgement judge_1(std::span<const std::byte> bytes);
  void drop_first();

  std::array<std::byte, kBufferBytes> buffer_{};
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  bool in_step_ = true;     ///< the byte at begin_ follows a frame
  std::uint64_t base_ = 0;  ///< stream position of buffer_[0]
  ParserStats stats_;
};

}  // namespace m100::mavlink
