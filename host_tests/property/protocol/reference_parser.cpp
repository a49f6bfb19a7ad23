// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/property/protocol/reference_parser.h"

namespace m100::host_tests {
namespace {

/// Both checksums, bit by bit; a second implementation, so that a mistake in protocol/crc.cpp is found.
std::uint32_t checksum(const Bytes& stream, std::size_t from, std::size_t count, std::uint32_t polynomial) {
  std::uint32_t state = 0x3AA3;
  for (std::size_t i = from; i < from + count; ++i) {
    for (unsigned bit = 0; bit < 8; ++bit) {
      const std::uint32_t input = (std::to_integer<std::uint32_t>(stream[i]) >> bit) & 1U;
      const bool carry = ((state ^ input) & 1U) != 0;
      state = (state >> 1U) ^ (carry ? polynomial : 0U);
    }
  }
  return state;
}

struct Judge {
  const Bytes& stream;
  std::size_t at;

  unsigned byte(std::size_t i) const { return std::to_integer<unsigned>(stream[at + i]); }
  std::size_t length() const { return byte(1) + 256U * (byte(2) & 3U); }

  bool header_is_good() const {
    const bool fixed = byte(0) == 0xAA && byte(2) < 4 && byte(3) < 64 && byte(5) == 0 && byte(6) == 0 && byte(7) == 0;
    if (!fixed || checksum(stream, at, 10, 0xA001) != byte(10) + 256U * byte(11)) {
      return false;
    }
    if (length() != 12 && length() < 16) {
      return false;
    }
    const std::size_t data = length() == 12 ? 0 : length() - 16;
    const bool encrypted = byte(4) >= 32;
    return byte(4) % 32 <= data && (!encrypted || data % 16 == 0);
  }

  bool frame_is_good() const {
    const std::size_t end = length() - 4;
    const std::uint32_t sent = byte(end) + (byte(end + 1) << 8U) + (byte(end + 2) << 16U) + (byte(end + 3) << 24U);
    return checksum(stream, at, end, 0xEDB88320U) == sent;
  }
};

}  // namespace

std::vector<FoundFrame> slow_parse(const Bytes& stream) {
  std::vector<FoundFrame> frames;
  std::size_t at = 0;
  while (at + 12 <= stream.size()) {
    const Judge judge{stream, at};
    if (!judge.header_is_good()) {
      ++at;
      continue;
    }
    const std::size_t length = judge.length();
    if (at + length > stream.size()) {
      break;
    }
    if (length > 12 && !judge.frame_is_good()) {
      ++at;
      continue;
    }
    const auto first = stream.begin() + static_cast<std::ptrdiff_t>(at);
    frames.push_back({at, Bytes(first, first + static_cast<std::ptrdiff_t>(length))});
    at += length - 11;
  }
  return frames;
}

}  // namespace m100::host_tests
