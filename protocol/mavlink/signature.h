// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/core/status.h"
#include "protocol/mavlink/frame.h"

namespace m100::mavlink {

using Key = std::array<std::byte, 32>;

/// The time of a signature: units of 10 microseconds since 2015-01-01 UTC, of which 48 bits are sent.
using SignatureTime = std::uint64_t;
inline constexpr SignatureTime kSignatureTicksPerSecond = 100000;
inline constexpr SignatureTime kSignatureTimeMask = (SignatureTime{1} << 48U) - 1;
/// Unix time of the origin.
inline constexpr std::int64_t kSignatureEpoch_s = 1420070400;

/// Signs a frame of make_frame(): sets its flag, repeats its checksum, and appends 13 bytes. @param time must be larger
/// than that of every frame signed before, with this key on this link.
void sign(Frame& frame, const Key& key, std::uint8_t link, SignatureTime time);

struct SignatureView {
  std::uint8_t link = 0;
  SignatureTime time = 0;
};
/// @param frame is_signed
SignatureView signature_of(const FrameView& frame);

/// Whether the signature was made with this key: the first 48 bits of SHA-256 over key, frame, link and time. Compares
/// in constant time. false too where the frame carries none.
bool is_signed_with(const FrameView& frame, const Key& key);

/// The newest signature of one stream: who sends, over which of his links.
struct ReplayStream {
  Address from;
  std::uint8_t link = 0;
  SignatureTime last = 0;
};

/// What must outlive a restart, so that a recording of the flight before cannot be played back.
struct ReplayMemory {
  static constexpr std::size_t kStreams = 16;
  std::array<ReplayStream, kStreams> streams{};
  std::size_t count = 0;
  SignatureTime newest = 0;  ///< of all that was ever accepted, also of streams that were forgotten
};

/// Refuses what was sent before. A signed frame counts if its time is newer than the last of its stream, and the first
/// of a stream in this life may lie no more than a minute behind the newest time that is known: whoever recorded an
/// older flight cannot play it back. Constant memory: where all streams are taken, one that is more than a minute
/// behind makes room (what it would still send is refused as old); where there is none, the new one is refused.
class ReplayGuard {
 public:
  static constexpr std::size_t kStreams = ReplayMemory::kStreams;
  static constexpr SignatureTime kLatestStart = 60 * kSignatureTicksPerSecond;

  ReplayGuard() = default;
  /// @param memory of the program's life before.
  explicit ReplayGuard(const ReplayMemory& memory) : memory_(memory), newest_(memory.newest) {
    M100_ASSERT(memory.count <= kStreams);
  }

  /// @param now the time of the signature that we would give; moves the newest known time on.
  /// @returns kOk: newer than all of its stream. kRefused: a replay, or overtaken on its way. kTimeout: a time stamp
  ///   too old for the first of a stream. kResourceExhausted: too many streams.
  core::Status accept(Address from, const SignatureView& signature, SignatureTime now);

  /// The newest time that was accepted or handed in: ours must not lie behind it.
  SignatureTime newest() const { return newest_; }
  const ReplayMemory& memory() const { return memory_; }

 private:
  ReplayMemory memory_{};
  std::array<bool, kStreams> heard_{};  ///< in this life
  SignatureTime newest_ = 0;
};

}  // namespace m100::mavlink
