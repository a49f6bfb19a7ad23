// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/dji/frame.h"

#include <algorithm>

namespace m100::protocol {

core::Expected<Message> open(const FrameView& frame, const Cipher* cipher, CipherScratch& scratch) {
  std::span<const std::byte> plain = frame.data;
  Message message{.header = frame.header, .has_id = false, .id = {}, .value = {}, .filler = {}};
  if (frame.header.encrypted()) {
    if (cipher == nullptr) {
      return core::Status::kUnavailable;
    }
    const std::size_t size = plain.size();
    if (size % kCipherBlockBytes != 0 || size > scratch.size() || frame.header.padding_bytes > size) {
      return core::Status::kInvalidArgument;
    }
    std::copy(plain.begin(), plain.end(), scratch.begin());
    for (std::size_t at = 0; at < size; at += kCipherBlockBytes) {
      cipher->decrypt(std::span(scratch).subspan(at).first<kCipherBlockBytes>());
    }
    plain = std::span<const std::byte>(scratch).first(size - frame.header.padding_bytes);
    message.filler = std::span<const std::byte>(scratch).subspan(plain.size(), frame.header.padding_bytes);
  }
  message.has_id = !frame.header.is_ack && plain.size() >= kMessageIdBytes;
  if (message.has_id) {
    message.id = {std::to_integer<std::uint8_t>(plain[0]), std::to_integer<std::uint8_t>(plain[1])};
    plain = plain.subspan(kMessageIdBytes);
  }
  message.value = plain;
  return message;
}

}  // namespace m100::protocol
