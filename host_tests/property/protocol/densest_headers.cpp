// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <utility>

#include "host_tests/property/protocol/streams.h"
#include "protocol/crc.h"

namespace m100::host_tests {
namespace {

/// The free bytes of a header that begins eight bytes after another: bytes 1 to 3 (LEN, SESSION), then byte 4.
struct DenseHeader {
  std::uint32_t start = 0;  ///< bytes 1 to 3, little-endian
  std::uint8_t cipher = 0;

  std::size_t length() const { return start & 0x3FFU; }
};

bool filler_fits(std::size_t length, unsigned cipher) {
  const std::size_t data = length - protocol::kFrameOverheadBytes;
  return (cipher & 0x1FU) <= data && (cipher < 0x20 || data % protocol::kCipherBlockBytes == 0);
}

std::uint16_t crc_of(std::size_t place, std::uint8_t value, std::uint16_t state = 0) {
  std::array<std::byte, 10> bytes{};
  bytes.at(place) = static_cast<std::byte>(value);
  return protocol::crc16(bytes, state);
}

/// VER and RES0 of the next header, in the CRC16 of this one.
constexpr std::uint16_t kFixedOfNext = 0xC0FC;

/// CRC16 is a sum of contributions of the bytes. Groups the values of byte 9 by their effect on kFixedOfNext.
struct ByteNineIndex {
  std::map<std::uint16_t, std::vector<std::uint8_t>> values;
  std::array<std::uint16_t, 256> crc{};
  std::array<std::uint16_t, 256> crc_of_byte_four{};

  ByteNineIndex() {
    for (unsigned value = 0; value < 256; ++value) {
      crc.at(value) = crc_of(9, static_cast<std::uint8_t>(value));
      crc_of_byte_four.at(value) = crc_of(4, static_cast<std::uint8_t>(value));
      values[crc.at(value) & kFixedOfNext].push_back(static_cast<std::uint8_t>(value));
    }
  }
};

/// All possible successors of a header: byte 4 of this one, and bytes 1 to 3 of the next, two of which are this CRC16.
std::vector<std::pair<std::uint8_t, std::uint32_t>> dense_followers(std::uint32_t start, std::mt19937& random) {
  static const ByteNineIndex kByByteNine;
  std::vector<std::pair<std::uint8_t, std::uint32_t>> followers;
  std::array<std::byte, 10> bytes{protocol::kStartByte};
  for (std::size_t i = 0; i < 3; ++i) {
    bytes.at(1 + i) = static_cast<std::byte>((start >> (8 * i)) & 0xFFU);
  }
  bytes[8] = protocol::kStartByte;
  const std::uint16_t rest = protocol::crc16(bytes);
  for (unsigned cipher = 0; cipher < 256; ++cipher) {
    const auto without_nine = static_cast<std::uint16_t>(rest ^ kByByteNine.crc_of_byte_four.at(cipher));
    const auto found = kByByteNine.values.find(without_nine & kFixedOfNext);
    if (!filler_fits(start & 0x3FFU, cipher) || found == kByByteNine.values.end()) {
      continue;
    }
    for (const std::uint8_t low : found->second) {
      const std::uint32_t next = low | static_cast<std::uint32_t>(without_nine ^ kByByteNine.crc.at(low)) << 8U;
      if ((next & 0x3FFU) >= protocol::kFrameOverheadBytes) {
        followers.emplace_back(static_cast<std::uint8_t>(cipher), next);
      }
    }
  }
  std::shuffle(followers.begin(), followers.end(), random);
  return followers;
}

/// Finds a cycle of headers that follow each other every eight bytes, by a depth-first search that remembers dead ends.
std::vector<DenseHeader> dense_cycle(std::mt19937& random) {
  struct Visit {
    std::uint32_t start;
    std::vector<std::pair<std::uint8_t, std::uint32_t>> left;
    std::uint8_t taken = 0;
  };
  std::set<std::uint32_t> seen;
  for (std::uint32_t first = protocol::kFrameOverheadBytes;; ++first) {
    std::vector<Visit> path{{first, dense_followers(first, random)}};
    seen.insert(first);
    while (!path.empty()) {
      Visit& at = path.back();
      if (at.left.empty()) {
        path.pop_back();
        continue;
      }
      const auto next = at.left.back().second;
      at.taken = at.left.back().first;
      at.left.pop_back();
      const auto back = std::find_if(path.begin(), path.end(), [&](const Visit& visit) { return visit.start == next; });
      if (back != path.end()) {
        std::vector<DenseHeader> cycle;
        std::transform(back, path.end(), std::back_inserter(cycle), [](const Visit& visit) {
          return DenseHeader{visit.start, visit.taken};
        });
        return cycle;
      }
      if (seen.insert(next).second) {
        path.push_back({next, dense_followers(next, random)});
      }
    }
  }
}

}  // namespace

Bytes densest_headers(std::size_t count, unsigned seed) {
  static std::map<unsigned, std::vector<DenseHeader>> known;  // a search takes milliseconds
  std::vector<DenseHeader>& cycle = known[seed];
  if (cycle.empty()) {
    std::mt19937 random(seed);
    cycle = dense_cycle(random);
  }
  Bytes stream(seed % 8);
  for (std::size_t i = 0; stream.size() < count; ++i) {
    const DenseHeader& header = cycle[i % cycle.size()];
    stream.push_back(protocol::kStartByte);
    for (unsigned shift = 0; shift < 24; shift += 8) {
      stream.push_back(static_cast<std::byte>((header.start >> shift) & 0xFFU));
    }
    stream.push_back(static_cast<std::byte>(header.cipher));
    append(stream, Bytes(3));
  }
  return stream;
}

}  // namespace m100::host_tests
