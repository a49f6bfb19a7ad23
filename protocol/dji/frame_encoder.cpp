// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/dji/frame_encoder.h"

#include "protocol/bytes.h"
#include "protocol/crc.h"

namespace m100::protocol {
namespace {

core::Status check(const Envelope& envelope, const MessageId* id, std::size_t data_bytes, const Cipher* cipher) {
  if (envelope.session >= kSessionCount || (envelope.is_ack && id != nullptr) ||
      (envelope.encrypted && data_bytes == 0)) {
    return core::Status::kInvalidArgument;
  }
  if (frame_bytes(data_bytes, envelope.encrypted) > kMaxFrameBytes) {
    return core::Status::kOutOfRange;
  }
  return envelope.encrypted && cipher == nullptr ? core::Status::kUnavailable : core::Status::kOk;
}

void write_header(ByteWriter& writer, const Envelope& envelope, std::size_t length, std::size_t padding) {
  writer.put(std::to_integer<std::uint8_t>(kStartByte));
  writer.put(static_cast<std::uint16_t>(length));
  writer.put(static_cast<std::uint8_t>(envelope.session | (envelope.is_ack ? 0x20U : 0U)));
  writer.put(static_cast<std::uint8_t>(padding | (envelope.encrypted ? 0x20U : 0U)));
  writer.put(std::array<std::uint8_t, 3>{});
  writer.put(envelope.sequence);
  writer.put(crc16(writer.written()));
}

}  // namespace

core::Expected<std::span<const std::byte>> encode_frame(const Envelope& envelope, const MessageId* id,
                                                        std::span<const std::byte> value, std::span<std::byte> space,
                                                        const Cipher* cipher, std::span<const std::byte> filler) {
  const std::size_t data_bytes = value.size() + (id != nullptr ? kMessageIdBytes : 0);
  if (const core::Status status = check(envelope, id, data_bytes, cipher); status != core::Status::kOk) {
    return status;
  }
  const std::size_t length = frame_bytes(data_bytes, envelope.encrypted);
  if (space.size() < length) {
    return core::Status::kResourceExhausted;
  }
  const std::size_t padding = envelope.encrypted ? length - kFrameOverheadBytes - data_bytes : 0;
  ByteWriter writer(space.first(length));
  write_header(writer, envelope, length, padding);
  if (data_bytes == 0) {
    return std::span<const std::byte>(writer.written());
  }
  if (id != nullptr) {
    writer.put(id->set);
    writer.put(id->id);
  }
  writer.put(value);
  for (std::size_t i = 0; i < padding; ++i) {
    writer.put(i < filler.size() ? std::to_integer<std::uint8_t>(filler[i]) : std::uint8_t{0});
  }
  if (envelope.encrypted) {
    for (std::size_t at = kHeaderBytes; at < length - 4; at += kCipherBlockBytes) {
      cipher->encrypt(space.subspan(at).first<kCipherBlockBytes>());
    }
  }
  writer.put(crc32(writer.written()));
  return std::span<const std::byte>(writer.written());
}

}  // namespace m100::protocol
