// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>
#include <tuple>
#include <utility>

#include "protocol/bytes.h"

namespace m100::mavlink {

/// The constants of one type of message: id, CRC_EXTRA and sizes.
struct MessageInfo {
  std::uint32_t id = 0;
  std::uint8_t crc_extra = 0;   ///< part of the frame's checksum: ensures that both sides use the same layout
  std::uint8_t min_bytes = 0;   ///< payload without extension fields: that of MAVLink 1
  std::uint8_t full_bytes = 0;  ///< payload with them
};

/// One field: its name in the message definition, and where it is kept.
template <typename Message, typename Value>
struct Field {
  std::string_view name;
  Value Message::*member;
};

template <typename Message, typename Value>
constexpr Field<Message, Value> field(std::string_view name, Value Message::*member) {
  return {name, member};
}

/// The fields of a message in the order of the wire; specialised for each message that messages.h lists.
template <typename Message>
inline constexpr auto kFields = std::tuple<>{};

/// Calls use(field) for each field in the order of the wire.
template <typename Message, typename Use>
constexpr void for_each_field(Use&& use) {
  std::apply([&use](const auto&... one) { (use(one), ...); }, kFields<Message>);
}

template <typename Message>
constexpr std::size_t wire_bytes() {
  std::size_t bytes = 0;
  for_each_field<Message>([&bytes](const auto& one) { bytes += sizeof(std::declval<Message>().*(one.member)); });
  return bytes;
}

/// Writes all fields, extensions included: full_bytes bytes. @returns the written bytes.
template <typename Message>
std::span<std::byte> encode_payload(const Message& message, std::span<std::byte> space) {
  static_assert(wire_bytes<Message>() == Message::kInfo.full_bytes, "the fields are not those of the definition");
  protocol::ByteWriter writer(space);
  for_each_field<Message>([&](const auto& one) { writer.put(message.*(one.member)); });
  return writer.written();
}

/// Loads one field's number or numbers, whose bytes must all be there. @returns where the next field begins.
template <typename Value>
const std::byte* load_field(const std::byte* at, Value& value) {
  value = protocol::load<Value>(at);
  return at + sizeof(Value);
}

template <typename Value, std::size_t kCount>
const std::byte* load_field(const std::byte* at, std::array<Value, kCount>& values) {
  std::memcpy(values.data(), at, sizeof(values));
  return at + sizeof(values);
}

/// Reads a payload whose trailing zeros may be missing (MAVLink 2 leaves them out), or that is longer than we know.
template <typename Message>
Message decode_payload(std::span<const std::byte> payload) {
  static_assert(wire_bytes<Message>() == Message::kInfo.full_bytes, "the fields are not those of the definition");
  std::array<std::byte, wire_bytes<Message>()> whole;
  const std::size_t came = payload.size() < whole.size() ? payload.size() : whole.size();
  std::memcpy(whole.data(), payload.data(), came);
  std::memset(whole.data() + came, 0, whole.size() - came);
  Message message;
  const std::byte* at = whole.data();
  for_each_field<Message>([&](const auto& one) { at = load_field(at, message.*(one.member)); });
  return message;
}

}  // namespace m100::mavlink
