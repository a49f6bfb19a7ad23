// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/mavlink/signature.h"

#include <algorithm>
#include <span>

#include "firmware/core/sha256.h"
#include "protocol/bytes.h"

namespace m100::mavlink {
namespace {

constexpr std::size_t kSealBytes = 6;
using Seal = std::array<std::byte, kSealBytes>;

/// @param bytes from the start byte up to and including the time stamp.
Seal seal_of(std::span<const std::byte> bytes, const Key& key) {
  core::Sha256 hash;
  hash.update(key);
  hash.update(bytes);
  const core::Sha256Digest digest = hash.finish();
  Seal seal;
  std::transform(digest.begin(), digest.begin() + kSealBytes, seal.begin(),
                 [](std::uint8_t b) { return std::byte{b}; });
  return seal;
}

}  // namespace

void sign(Frame& frame, const Key& key, std::uint8_t link, SignatureTime time) {
  M100_ASSERT(frame.size >= kHeader2Bytes + kCrcBytes && frame.size + kSignatureBytes <= frame.space.size());
  frame.space[2] |= std::byte{kSignedFlag};
  const std::uint32_t id = std::to_integer<std::uint32_t>(frame.space[7]) |
                           (std::to_integer<std::uint32_t>(frame.space[8]) << 8U) |
                           (std::to_integer<std::uint32_t>(frame.space[9]) << 16U);
  const MessageInfo* const info = find_message(id);
  M100_ASSERT(info != nullptr);
  const std::byte extra{info->crc_extra};
  const std::size_t summed = frame.size - kCrcBytes;
  protocol::ByteWriter writer(std::span(frame.space).subspan(summed));
  writer.put(checksum(std::span(&extra, 1), checksum(frame.bytes().subspan(1, summed - 1))));
  writer.put(link);
  for (unsigned shift = 0; shift < 48; shift += 8) {
    writer.put(static_cast<std::uint8_t>((time >> shift) & 0xFFU));
  }
  frame.size += kSignatureBytes - kSealBytes;
  const Seal seal = seal_of(frame.bytes(), key);
  writer.put(std::span<const std::byte>(seal));
  frame.size += kSealBytes;
}

SignatureView signature_of(const FrameView& frame) {
  M100_ASSERT(frame.is_signed && frame.bytes.size() >= kSignatureBytes);
  protocol::ByteReader reader(frame.bytes.last(kSignatureBytes));
  SignatureView signature{.link = reader.take<std::uint8_t>()};
  for (unsigned shift = 0; shift < 48; shift += 8) {
    signature.time |= SignatureTime{reader.take<std::uint8_t>()} << shift;
  }
  return signature;
}

bool is_signed_with(const FrameView& frame, const Key& key) {
  if (!frame.is_signed || frame.bytes.size() < kSignatureBytes) {
    return false;
  }
  const Seal expected = seal_of(frame.bytes.first(frame.bytes.size() - kSealBytes), key);
  const std::span<const std::byte> given = frame.bytes.last(kSealBytes);
  std::byte differs{0};
  for (std::size_t i = 0; i < kSealBytes; ++i) {
    differs |= expected[i] ^ given[i];
  }
  return differs == std::byte{0};
}

core::Status ReplayGuard::accept(Address from, const SignatureView& signature, SignatureTime now) {
  newest_ = std::max(newest_, now);
  const auto streams = std::span(memory_.streams).first(memory_.count);
  const auto known = std::find_if(streams.begin(), streams.end(), [&](const ReplayStream& stream) {
    return stream.from == from && stream.link == signature.link;
  });
  std::size_t at = static_cast<std::size_t>(known - streams.begin());
  if (known != streams.end() && signature.time <= known->last) {
    return core::Status::kRefused;
  }
  const auto is_old = [&](SignatureTime time) { return time + kLatestStart < newest_; };
  if ((known == streams.end() || !heard_[at]) && is_old(signature.time) && !accepts_any_clock_) {
    return core::Status::kTimeout;
  }
  if (known == streams.end() && at == kStreams) {
    const auto gone = std::find_if(streams.begin(), streams.end(), [&](const auto& one) { return is_old(one.last); });
    if (gone == streams.end()) {
      return core::Status::kResourceExhausted;
    }
    at = static_cast<std::size_t>(gone - streams.begin());
  }
  memory_.count = std::max(memory_.count, at + 1);
  memory_.streams[at] = {.from = from, .link = signature.link, .last = signature.time};
  heard_[at] = true;
  memory_.newest = std::max(memory_.newest, signature.time);
  newest_ = std::max(newest_, signature.time);
  return core::Status::kOk;
}

}  // namespace m100::mavlink
