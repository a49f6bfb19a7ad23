// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/core/expected.h"
#include "protocol/dji/frame.h"

namespace m100::protocol {

/// Counters of the parser. An error is a start byte outside of all delivered frames at which no frame begins.
struct ParserStats {
  std::uint64_t bytes = 0;   ///< taken
  std::uint64_t frames = 0;  ///< delivered
  std::uint64_t crc16_errors =
      0;  ///< start byte, but no header: its checksum fails or (out of step) a fixed bit is set
  std::uint64_t reserved_errors = 0;  ///< where a frame was due: good header checksum, but VER, RES0 or RES1 not zero
  std::uint64_t length_errors = 0;   ///< good header checksum, but a LEN that no frame can have or that is not expected
  std::uint64_t padding_errors = 0;  ///< more filler than DATA, or encrypted DATA that is not whole cipher blocks
  std::uint64_t crc32_errors = 0;    ///< good header, but the frame checksum fails
  std::uint64_t resyncs = 0;         ///< how often synchronisation was lost: runs of dropped bytes
  std::uint64_t bytes_dropped = 0;   ///< bytes that belong to no delivered frame
  friend constexpr bool operator==(const ParserStats&, const ParserStats&) = default;
};

/// Finds frames in a byte stream that may start anywhere and may be damaged anywhere.
///
/// Invariants, whatever the bytes are: no more than kBufferBytes are stored; no frame is reported unless both checksums
/// hold; a good frame that overlaps no delivered one is delivered once no earlier start byte can claim its bytes. After
/// any damage this takes at most one longest frame of clean bytes.
///
/// Cost: the bytes of a false frame are searched again from the second one. Good headers of false frames cannot begin
/// nearer than eight bytes to each other, so a byte is summed at most longest_frame_bytes / 8 times.
class FrameParser {
 public:
  static constexpr std::size_t kBufferBytes = 2048;

  /// @param longest_frame_bytes no longer frame is expected: a header that claims more begins no frame.
  explicit FrameParser(std::size_t longest_frame_bytes = kMaxFrameBytes) : longest_frame_bytes_(longest_frame_bytes) {}

  /// Takes as many bytes as there is room for; after poll() returned kNotReady there is room for at least 1000.
  /// Invalidates the views of earlier frames.
  /// @returns the number of bytes taken.
  [[nodiscard]] std::size_t push(std::span<const std::byte> bytes);

  /// The next frame. It views the parser's buffer until the next push().
  /// @returns kNotReady: none is complete yet.
  core::Expected<FrameView> poll();

  /// Feeds one byte and polls. One byte can complete several frames (those inside the bytes that a false header
  /// claimed): after a frame, call poll() until kNotReady. @returns kResourceExhausted: no room, because poll() was not
  /// called.
  core::Expected<FrameView> push(std::byte value);

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

  /// Abandons the pending frame and continues the search after its start byte. For a link that became silent in the
  /// middle of a frame: the next bytes are not its rest. Call poll() afterwards.
  void abandon_candidate();

  /// LEN of the pending frame's header; 0: no frame is pending.
  std::size_t claimed_bytes() const { return needed_ > kHeaderBytes ? needed_ : 0; }
  /// Where in the stream that header begins.
  std::uint64_t candidate_offset() const { return base_ + begin_; }

  const ParserStats& stats() const { return stats_; }
  /// Bytes taken, but neither delivered nor dropped yet.
  std::size_t pending_bytes() const { return end_ - (begin_ > delivered_ ? begin_ : delivered_); }

 private:
  /// Moves the window to its first frame, whose bytes are all there, or to what must be waited for (false).
  bool find_frame();
  /// Judges the twelve bytes at a start byte. @returns the length of the frame; 0 and a counted error: no header.
  std::size_t judge_header(const std::byte* at);
  /// Counts a start byte at which no frame begins, unless it lies inside a delivered frame.
  void count_error(std::uint64_t ParserStats::*counter, const std::byte* at);
  /// Advances the window. Bytes that leave it and belong to no delivered frame count as dropped.
  void move_to(const std::byte* at, std::size_t needed);
  FrameView deliver();

  std::array<std::byte, kBufferBytes> buffer_{};
  std::size_t longest_frame_bytes_;
  std::size_t begin_ = 0;      ///< window start
  std::size_t end_ = 0;        ///< bytes in the buffer
  std::size_t delivered_ = 0;  ///< end of the last delivered frame
  std::size_t needed_ = 1;     ///< window size at which there is something to do; above kHeaderBytes: LEN of a header
  bool in_step_ = true;
  std::uint64_t base_ = 0;  ///< stream position of buffer_[0]
  ParserStats stats_;
};

}  // namespace m100::protocol
