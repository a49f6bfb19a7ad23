// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/core/time.h"
#include "hal/packet_uart.h"
#include "protocol/mavlink/parser.h"
#include "protocol/mavlink/signature.h"

namespace m100::link {

/// Counts of a SignedLine: frames with a valid checksum, by their result, and interrupted ticks.
struct SignedLineStats {
  std::uint64_t accepted = 0;
  std::uint32_t unsigned_frames = 0;
  std::uint32_t wrong = 0;            ///< signed with another key, or changed on the way
  std::uint32_t replayed = 0;         ///< not newer than the stream's last one: a replay, duplicated, or overtaken
  std::uint32_t old = 0;              ///< the first of a stream, stamped over a minute before the newest known time
  mavlink::SignatureTime old_by = 0;  ///< by how much the last of those was before the newest known time
  std::uint32_t too_many = 0;         ///< of a new stream, while the memory of streams is full
  std::uint32_t interrupted = 0;      ///< ticks whose work budget was used up, so that bytes may have had to wait

  std::uint64_t refused() const { return std::uint64_t{unsigned_frames} + wrong + replayed + old + too_many; }
};

/// A line that passes on only frames that are signed with the key and did not come before. It signs every frame that is
/// written. Its reader gets no other bytes, so a log of what it reads replays without the key.
///
/// It works in the thread that flies, so that a simulated flight gives the same result each time. The cost of a tick is
/// bounded: at most kReadsPerTick reads of kChunk bytes and kVerificationsPerTick signatures (at most five blocks of
/// SHA-256 each). Further bytes wait, and the kernel discards bytes that wait too long. A tick after a stall may do
/// kLateFactor times as much.
class SignedLine final : public hal::Uart {
 public:
  static constexpr std::size_t kChunk = 256;
  static constexpr std::uint32_t kReadsPerTick = 16;
  static constexpr std::uint32_t kVerificationsPerTick = 48;
  static constexpr std::uint32_t kLateFactor = 8;

  /// The line must outlive it; key and known are copied. @param link our link id, signed with what is written.
  SignedLine(hal::PacketUart& line, const mavlink::Key& key, const mavlink::ReplayMemory& known, std::uint8_t link)
      : SignedLine(line, &line, key, known, link) {}
  SignedLine(hal::Uart& line, const mavlink::Key& key, const mavlink::ReplayMemory& known, std::uint8_t link)
      : SignedLine(line, nullptr, key, known, link) {}

  /// @param accepts true: the first frame of a stream may be old; see ReplayGuard.
  void accept_any_clock(bool accepts) { guard_.accept_any_clock(accepts); }
  /// Call it once per tick, before read(). @param time the time stamp of a signature made now.
  void tick(core::TimePoint now, mavlink::SignatureTime time);

  core::Expected<std::size_t> read(std::span<std::byte> destination) override;
  /// @param source one frame of ours, unsigned. @returns kInvalidArgument: not one MAVLink 2 frame, or too long.
  core::Expected<std::size_t> write(std::span<const std::byte> source) override;

  const SignedLineStats& stats() const { return stats_; }
  const mavlink::ParserStats& parser_stats() const { return parser_.stats(); }
  const mavlink::ReplayMemory& memory() const { return guard_.memory(); }
  /// Smallest time stamp for a signature made now: not before any accepted stamp.
  mavlink::SignatureTime min_time() const { return time_ > guard_.newest() ? time_ : guard_.newest(); }

 private:
  SignedLine(hal::Uart& line, hal::PacketUart* packets, const mavlink::Key& key, const mavlink::ReplayMemory& known,
             std::uint8_t link)
      : line_(line), packets_(packets), key_(key), link_(link), guard_(known) {}
  bool accepts(const mavlink::FrameView& frame);
  /// Moves bytes from the line to the parser. @returns how many; 0: none arrived, or this tick's budget is used up.
  core::Expected<std::size_t> fill();

  hal::Uart& line_;
  hal::PacketUart* packets_;  ///< the same line if it has packets, otherwise null
  mavlink::Key key_;
  std::uint8_t link_;
  mavlink::ReplayGuard guard_;
  mavlink::Parser parser_;
  std::array<std::byte, kChunk> chunk_{};
  std::span<const std::byte> unread_;   ///< of chunk_, not yet in the parser
  std::span<const std::byte> granted_;  ///< of an accepted frame, not yet passed on; views the parser's buffer
  bool ticked_ = false;
  core::TimePoint last_tick_{};
  mavlink::SignatureTime time_ = 0;
  mavlink::SignatureTime last_signed_ = 0;
  std::uint32_t reads_left_ = 0;
  std::uint32_t verifications_left_ = 0;
  SignedLineStats stats_;
};

}  // namespace m100::link
