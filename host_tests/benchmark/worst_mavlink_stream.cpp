// SPDX-License-Identifier: BSD-3-Clause
// Searches for the stream with the highest cost in the MAVLink parser; worst_stream.sh runs it under callgrind and
// prints the most expensive stream of each family. Every stream is one dump, whose trigger line names the stream.
//   worst_mavlink_stream STREAMS   each family with that many seeds
#include <valgrind/callgrind.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>

#include "host_tests/property/mavlink/streams.h"
#include "protocol/mavlink/parser.h"

namespace {

using namespace m100;
namespace streams = host_tests::mavlink_streams;
using streams::Bytes;

constexpr std::size_t kStreamBytes = 40'000;
constexpr std::size_t kReadBytes = 4096;  // what a serial driver hands over at once, at most

/// Not inlined, so that a run counts the parser and nothing of the search.
[[gnu::noinline]] mavlink::ParserStats receive(std::span<const std::byte> stream) {
  mavlink::Parser parser;
  while (!stream.empty()) {
    const std::size_t count = std::min(stream.size(), kReadBytes);
    parser.consume(stream.first(count), [](const mavlink::FrameView&) {});
    stream = stream.subspan(count);
  }
  return parser.stats();
}

Bytes clean(std::mt19937& /*random*/) { return streams::clean_poses(kStreamBytes); }
Bytes random_bytes(std::mt19937& random) {
  Bytes stream(kStreamBytes);
  std::generate(stream.begin(), stream.end(), [&random] { return static_cast<std::byte>(random() & 0xFFU); });
  return stream;
}
Bytes starts(std::mt19937& random) {
  return streams::start_bytes(kStreamBytes, random() % 2 == 0 ? mavlink::kStart2 : mavlink::kStart1);
}
Bytes densest(std::mt19937& /*random*/) { return streams::densest_headers(kStreamBytes); }
Bytes patterns(std::mt19937& random) { return streams::pattern(random, kStreamBytes); }
Bytes headers(std::mt19937& random) { return streams::headers(random, kStreamBytes); }
Bytes frames(std::mt19937& random) { return streams::frames_among_headers(random, kStreamBytes); }

/// Changes a pattern byte by byte, and keeps each change that makes the parser sum at least as many claims.
Bytes climbed(std::mt19937& random) {
  constexpr std::size_t kShort = 3000;
  constexpr int kChanges = 400;
  Bytes period(3 + random() % 30);
  const auto repeated = [&period](std::size_t count) {
    Bytes stream;
    while (stream.size() < count) {
      streams::append(stream, period);
    }
    return stream;
  };
  std::uint64_t most = 0;
  for (int change = 0; change < kChanges; ++change) {
    const Bytes kept = period;
    for (std::size_t i = 0; i <= random() % 3; ++i) {
      const Bytes part = streams::pattern(random, 1);
      period[random() % period.size()] = part[0];
    }
    const std::uint64_t sums = receive(repeated(kShort)).crc_errors;
    period = sums >= most ? period : kept;
    most = std::max(most, sums);
  }
  return repeated(kStreamBytes);
}

/// Alternates between pieces of the other streams.
Bytes mixture(std::mt19937& random) {
  constexpr std::array kKinds{patterns, headers, frames, densest, starts};
  const std::size_t piece = 20 + random() % 400;
  const std::array<Bytes, 3> sources{kKinds.at(random() % 5)(random), kKinds.at(random() % 5)(random), densest(random)};
  Bytes stream;
  for (std::size_t at = 0; stream.size() < kStreamBytes; at = (at + piece) % (kStreamBytes - piece)) {
    streams::append(stream, std::span(sources.at(random() % 3)).subspan(at, piece));
  }
  return stream;
}

struct Family {
  const char* name;
  Bytes (*make)(std::mt19937&);
};
constexpr std::array kFamilies{Family{"clean", clean},     Family{"random", random_bytes}, Family{"starts", starts},
                               Family{"densest", densest}, Family{"pattern", patterns},    Family{"headers", headers},
                               Family{"frames", frames},   Family{"climbed", climbed},     Family{"mixture", mixture}};

}  // namespace

int main(int argc, char** argv) {
  const unsigned count = argc == 2 ? static_cast<unsigned>(std::atoi(argv[1])) : 0;
  if (count == 0) {
    std::fprintf(stderr, "usage: worst_mavlink_stream STREAMS\n");
    return 2;
  }
  for (const Family& family : kFamilies) {
    for (unsigned seed = 0; seed < count; ++seed) {
      std::mt19937 random(seed);
      const Bytes stream = family.make(random);
      const std::string name =
          std::string(family.name) + ' ' + std::to_string(seed) + ' ' + std::to_string(stream.size());
      CALLGRIND_ZERO_STATS;
      (void)receive(stream);
      CALLGRIND_DUMP_STATS_AT(name.c_str());
    }
  }
  return 0;
}
