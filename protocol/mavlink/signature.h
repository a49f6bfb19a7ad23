// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

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

/// Signs a frame of make_frame(): sets its flag, recomputes its checksum, and appends 13 bytes. @param time must be
/// later than that of every earlier frame signed with this key on this link.
void sign(Frame& frame, const Key& key, std::uint8_t link, SignatureTime time);

struct SignatureView {
  std::uint8_t link = 0;
  SignatureTime time = 0;
};
/// @param frame is_signed
SignatureView signature_of(const FrameView& frame);

/// Whether the signature was made with this key: the first 48 bits of SHA-256 over key, frame, link and time. Compares
/// in constant time. Also false if the frame carries no signature.
bool is_signed_with(const FrameView& frame, const Key& key);

/// The newest signature of one stream: a sender and one of its links.
struct ReplayStream {
  Address from;
  std::uint8_t link = 0;
  SignatureTime last = 0;
};

/// The state that must survive a restart, so that a recording of an earlier flight cannot be replayed.
struct ReplayMemory {
  static constexpr std::size_t kStreams = 16;
  std::array<ReplayStream, kStreams> streams{};
  std::size_t count = 0;
  SignatureTime newest = 0;  ///< the newest ever accepted, also of forgotten streams
};

/// Refuses replays. A signed frame is accepted if its time is newer than the last of its stream. The first frame of a
/// stream since the start may lie at most a minute behind the newest known time, so that a recording of an older flight
/// cannot be replayed. Constant memory: if all streams are in use, a new one takes the place of one that is more than a
/// minute behind; if there is none, it is refused.
class ReplayGuard {
 public:
  static constexpr std::size_t kStreams = ReplayMemory::kStreams;
  static constexpr SignatureTime kLatestStart = 60 * kSignatureTicksPerSecond;

  ReplayGuard() = default;
  /// @param memory of the program's previous run.
  explicit ReplayGuard(const ReplayMemory& memory) : memory_(memory), newest_(memory.newest) {
    M100_ASSERT(memory.count <= kStreams);
  }

  /// Accepts the first frame of a stream however old its time is, if the operator allows it: a signer without a clock
  /// of its own continues from an old time. In a known stream the times must still rise.
  void accept_any_clock(bool accepts) { accepts_any_clock_ = accepts; }

  /// @param now the time of our own signatures; it advances the newest known time.
  /// @returns kOk: newer than all earlier ones of its stream. kRefused: a replay, or overtaken. kTimeout: a time stamp
  ///   too old for the first of a stream. kResourceExhausted: too many streams.
  core::Status accept(Address from, const SignatureView& signature, SignatureTime now);

  /// The newest time that was accepted or passed in: our own signatures must not be older.
  SignatureTime newest() const { return newest_; }
  const ReplayMemory& memory() const { return memory_; }

 private:
  ReplayMemory memory_{};
  std::array<bool, kStreams> heard_{};  ///< the stream has sent since the start of the program
  SignatureTime newest_ = 0;
  bool accepts_any_clock_ = false;
};

}  // namespace m100::mavlink
