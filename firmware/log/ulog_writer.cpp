// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/log/ulog_writer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <limits>

#include "firmware/core/assert.h"

namespace m100::log {
namespace {

static_assert(std::endian::native == std::endian::little, "ULog is little-endian, and so are all machines we fly on");

std::span<const std::byte> bytes_of(std::string_view text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

/// The first bytes of a message's content, before the caller's bytes.
class Head {
 public:
  void put(std::uint8_t value) {
    M100_ASSERT(size_ < bytes_.size());
    bytes_[size_++] = static_cast<std::byte>(value);
  }
  void put(std::uint16_t value) {
    put(static_cast<std::uint8_t>(value & 0xFFU));
    put(static_cast<std::uint8_t>(value >> 8U));
  }
  void put(std::string_view text) {
    for (const char letter : text) {
      put(static_cast<std::uint8_t>(letter));
    }
  }
  void put_decimal(std::size_t value) {
    std::array<char, 8> digits{};
    std::size_t count = 0;
    do {
      digits[count++] = static_cast<char>('0' + static_cast<char>(value % 10));
      value /= 10;
    } while (value > 0 && count < digits.size());
    while (count > 0) {
      put(static_cast<std::uint8_t>(digits[--count]));
    }
  }
  std::span<const std::byte> span() const { return std::span(bytes_).first(size_); }
  std::size_t size() const { return size_; }

 private:
  std::array<std::byte, 96> bytes_{};
  std::size_t size_ = 0;
};

}  // namespace

bool UlogWriter::message(char type, std::span<const std::byte> head, std::span<const std::byte> body) {
  std::array<std::byte, 96> front{};
  M100_ASSERT(3 + head.size() <= front.size() &&
              head.size() + body.size() <= std::numeric_limits<std::uint16_t>::max());
  const auto size = static_cast<std::uint16_t>(head.size() + body.size());
  front[0] = static_cast<std::byte>(size & 0xFFU);
  front[1] = static_cast<std::byte>(size >> 8U);
  front[2] = static_cast<std::byte>(type);
  std::copy(head.begin(), head.end(), front.begin() + 3);
  return ring_.push(std::span(front).first(3 + head.size()), body);
}

bool UlogWriter::note(const Note& note) {
  const std::string_view text = note.text;
  if (text.size() > kLongestNote_bytes) {
    return false;
  }
  Head type;
  type.put("char[");
  type.put_decimal(text.size());
  type.put("] ");
  type.put(note.key.substr(0, 40));
  Head head;
  head.put(static_cast<std::uint8_t>(type.size()));
  std::array<std::byte, 96> front{};
  M100_ASSERT(1 + type.size() <= front.size());
  std::copy(head.span().begin(), head.span().end(), front.begin());
  std::copy(type.span().begin(), type.span().end(), front.begin() + 1);
  return message('I', std::span(front).first(1 + type.size()), bytes_of(text));
}

core::Status UlogWriter::begin(core::TimePoint now, std::span<const std::string_view> formats,
                               std::span<const Note> notes) {
  constexpr std::array<std::uint8_t, 8> kMagic{0x55, 0x4C, 0x6F, 0x67, 0x01, 0x12, 0x35, 0x01};
  const auto start = static_cast<std::uint64_t>(now.time_since_epoch().count());
  const std::array<std::uint64_t, 1> time{start};
  bool room = ring_.push(std::as_bytes(std::span(kMagic)), std::as_bytes(std::span(time)));
  const std::array<std::byte, 40> no_flags{};
  room = message('B', {}, no_flags) && room;
  for (const std::string_view format : formats) {
    room = message('F', {}, bytes_of(format)) && room;
  }
  for (const Note& one : notes) {
    room = note(one) && room;
  }
  std::uint16_t id = 0;
  for (const std::string_view format : formats) {
    Head head;
    head.put(std::uint8_t{0});  // first instance
    head.put(id++);
    room = message('A', head.span(), bytes_of(format.substr(0, format.find(':')))) && room;
  }
  return room ? core::Status::kOk : core::Status::kResourceExhausted;
}

void UlogWriter::append(std::uint16_t id, std::span<const std::byte> record) {
  Head head;
  head.put(id);
  static_cast<void>(message('D', head.span(), record));  // a drop is counted by the ring
}

void UlogWriter::append(core::TimePoint now, std::string_view text) {
  constexpr auto kInfo = std::uint8_t{'6'};
  const auto timestamp = static_cast<std::uint64_t>(now.time_since_epoch().count());
  Head head;
  head.put(kInfo);
  for (unsigned shift = 0; shift < 64; shift += 8) {
    head.put(static_cast<std::uint8_t>((timestamp >> shift) & 0xFFU));
  }
  static_cast<void>(message('L', head.span(), bytes_of(text.substr(0, 60000))));
}

}  // namespace m100::log
