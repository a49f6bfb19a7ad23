// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/core/expected.h"
#include "protocol/mavlink/frame.h"
#include "protocol/mavlink/running_checksum.h"

namespace m100::mavlink {

struct ParserStats {
  std::uint64_t bytes = 0;          ///< taken
  std::uint64_t frames = 0;         ///< delivered
  std::uint64_t crc_errors = 0;     ///< a header of a known message, but the checksum fails
  std::uint64_t unknown = 0;        ///< where a frame was due: a message whose checksum cannot be verified
  std::uint64_t incompatible = 0;   ///< where a frame was due: an unknown flag, so the frame must not be read
  std::uint64_t bytes_dropped = 0;  ///< belong to no delivered frame
};

/// Finds frames of MAVLink 1 and 2 in a byte stream that may start anywhere and may be damaged anywhere.
///
/// Invariants, whatever the bytes are: at most kBufferBytes are stored; no frame is reported unless its checksum holds;
/// the bytes of a false frame are searched again from the second one, so that a good frame inside them, or directly
/// after them, is found. The checksum of an unknown message cannot be verified: it does not count as a frame, and its
/// bytes are searched like any others.
///
/// Cost: each byte enters the running checksum at most once, and each start byte costs a constant, whatever length its
/// header claims: a look-up of the message and, if it is known, one checksum of a range (running_checksum.h).
class Parser {
 public:
  static constexpr std::size_t kBufferBytes = RunningChecksum::kMaxBufferBytes;
  static_assert(kBufferBytes > kMaxFrameBytes, "there must be room for a byte whenever no frame is complete");

  /// Takes as many bytes as there is room for, at least one after poll() returned kNotReady. Invalidates the views of
  /// earlier frames. @returns the number of bytes taken.
  [[nodiscard]] std::size_t push(std::span<const std::byte> bytes);

  /// The next frame. It views the parser's buffer until the next push(). @returns kNotReady: none is complete yet.
  core::Expected<FrameView> poll() {
    if (end_ - begin_ < needed_) {
      return core::Status::kNotReady;
    }
    return search();
  }

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

  /// Forgets a frame that has begun: the next byte begins a network packet, not the rest of the previous one.
  void begin_packet();

  const ParserStats& stats() const { return stats_; }

 private:
  core::Expected<FrameView> search();
  /// Moves the window to its first frame, whose bytes are all there, or to what must be waited for.
  /// @returns the frame's message; null: the window must grow to needed_ bytes.
  const MessageInfo* find_frame();
  /// @returns the known message whose header begins at `at`, or null. An unknown message or flag is counted if `due`.
  /// @param due `at` directly follows a frame or begins the stream or a packet: a frame is expected there.
  const MessageInfo* read_header(const std::byte* at, bool due);
  bool checksum_holds(const std::byte* at, std::size_t summed_bytes, const MessageInfo& info);
  void move_to(const std::byte* at, std::size_t needed);

  std::array<std::byte, kBufferBytes> buffer_{};
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  std::size_t needed_ = 1;  ///< size of the window at which there is something to do
  bool in_step_ = true;     ///< the byte at begin_ follows a frame or begins the stream or a packet
  std::uint64_t base_ = 0;  ///< stream position of buffer_[0]
  RunningChecksum sums_;
  ParserStats stats_;
};

}  // namespace m100::mavlink
