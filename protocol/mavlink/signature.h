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

/// Refuses what was sent before. A signed frame counts if its time is newer than the last of its stream (who sends,
/// over which of his links), and a new stream may begin no more than a minute behind the newest time that is known:
/// whoever recorded an older flight cannot play it back. Constant memory: kStreams streams; one more is refused.
class ReplayGuard {
 public:
  static constexpr std::size_t kStreams = 16;
  static constexpr SignatureTime kLatestStart = 60 * kSignatureTicksPerSecond;

  /// @param now the time of the signature that we would give; moves the newest known time on.
  /// @returns kOk: newer than all of its stream. kRefused: a replay, or a time stamp too old for a new stream.
  ///   kResourceExhausted: too many streams.
  core::Status accept(Address from, const SignatureView& signature, SignatureTime now);

  /// The newest time that was accepted or handed in: ours must not lie behind it.
  SignatureTime newest() const { return newest_; }

 private:
  struct Stream {
    Address from;
    std::uint8_t link = 0;
    SignatureTime last = 0;
  };
  std::array<Stream, kStreams> streams_{};
  std::size_t count_ = 0;
  SignatureTime newest_ = 0;
};

}  // namespace m100::mavlink
