// SPDX-License-Identifier: BSD-3-Clause
// Searches for the stream with the highest parser cost; worst_stream.sh runs it under callgrind and prints the most
// expensive streams. Every stream is one dump, whose trigger line names the stream.
//   worst_stream STREAMS   each family with that many seeds
#include <valgrind/callgrind.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>

#include "host_tests/benchmark/receive.h"
#include "host_tests/property/protocol/densest_autopilot_headers.h"
#include "host_tests/property/protocol/streams.h"

namespace {

using namespace m100;
using host_tests::append;
using host_tests::Bytes;

constexpr std::size_t kStreamBytes = 40'000;

std::uint8_t any_byte(std::mt19937& random) { return static_cast<std::uint8_t>(random() & 0xFFU); }

/// A repeated pattern of bytes that have a meaning in a header.
Bytes pattern(std::mt19937& random) {
  constexpr std::array<std::uint8_t, 8> kAlphabet{0xAA, 0xAA, 0xAA, 0x00, 0x00, 0x00, 0x03, 0xFF};
  Bytes period(2 + random() % 23);
  for (std::byte& byte : period) {
    byte = static_cast<std::byte>(kAlphabet.at(random() % kAlphabet.size()));
  }
  Bytes stream;
  while (stream.size() < kStreamBytes) {
    append(stream, period);
  }
  return stream;
}

/// Headers of one kind with arbitrary LEN, SESSION, PADDING and ENC and a valid CRC16, separated by arbitrary gaps.
Bytes headers(std::mt19937& random) {
  const std::size_t length = random() % (protocol::kMaxAutopilotFrameBytes + 1);
  const std::uint8_t session = any_byte(random);
  const std::uint8_t cipher = random() % 2 == 0 ? std::uint8_t{0} : any_byte(random);
  const Bytes gap(random() % 9, random() % 2 == 0 ? protocol::kStartByte : std::byte{0});
  Bytes stream;
  for (std::uint16_t number = 0; stream.size() < kStreamBytes; ++number) {
    append(stream, host_tests::header(random() % 4 == 0 ? random() % (protocol::kMaxAutopilotFrameBytes + 1) : length,
                                      session, cipher, number));
    append(stream, gap);
  }
  return stream;
}

/// As many beginnings of valid headers as fit in; each makes the parser compute the CRC16.
Bytes beginnings(std::mt19937& random) {
  const Bytes gap(random() % 4, static_cast<std::byte>(any_byte(random)));
  Bytes stream;
  while (stream.size() < kStreamBytes) {
    const Bytes fixed{protocol::kStartByte, protocol::kStartByte, std::byte{1}, std::byte{2}, std::byte{0xAA},
                      std::byte{0},         std::byte{0},         std::byte{0}, std::byte{0}};
    append(stream, std::span(fixed).first(8 + random() % 2));
    append(stream, gap);
  }
  return stream;
}

/// Intact frames of one size.
Bytes small_frames(std::mt19937& random) {
  const Bytes value(random() % 60);
  Bytes stream;
  for (std::uint16_t number = 0; stream.size() < kStreamBytes; ++number) {
    append(stream, host_tests::make_frame({.is_ack = true, .sequence = number}, nullptr, value));
  }
  return stream;
}

Bytes densest(std::mt19937& random) {
  Bytes stream(random() % 8);
  for (std::size_t at = 0; stream.size() < kStreamBytes; ++at) {
    stream.push_back(host_tests::densest_autopilot_byte(at));
  }
  return stream;
}

/// Alternates between pieces of the other streams.
Bytes mixture(std::mt19937& random) {
  constexpr std::array kKinds{pattern, headers, beginnings, small_frames, densest};
  const std::size_t piece = 20 + random() % 200;
  const std::array<Bytes, 3> sources{kKinds.at(random() % 5)(random), kKinds.at(random() % 5)(random), densest(random)};
  Bytes stream;
  for (std::size_t at = 0; stream.size() < kStreamBytes; at = (at + piece) % (kStreamBytes - piece)) {
    append(stream, std::span(sources.at(random() % 3)).subspan(at, piece));
  }
  return stream;
}

struct Family {
  const char* name;
  Bytes (*make)(std::mt19937&);
};
constexpr std::array kFamilies{Family{"pattern", pattern},       Family{"headers", headers},
                               Family{"beginnings", beginnings}, Family{"small_frames", small_frames},
                               Family{"densest", densest},       Family{"mixture", mixture}};

}  // namespace

int main(int argc, char** argv) {
  const unsigned count = argc == 2 ? static_cast<unsigned>(std::atoi(argv[1])) : 0;
  if (count == 0) {
    std::fprintf(stderr, "usage: worst_stream STREAMS\n");
    return 2;
  }
  for (const Family& family : kFamilies) {
    for (unsigned seed = 0; seed < count; ++seed) {
      std::mt19937 random(seed);
      const Bytes stream = family.make(random);
      const std::string name =
          std::string(family.name) + ' ' + std::to_string(seed) + ' ' + std::to_string(stream.size());
      protocol::FrameParser parser{protocol::kMaxAutopilotFrameBytes};
      CALLGRIND_ZERO_STATS;
      (void)host_tests::receive(parser, stream);
      CALLGRIND_DUMP_STATS_AT(name.c_str());
    }
  }
  return 0;
}
