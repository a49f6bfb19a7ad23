// SPDX-License-Identifier: BSD-3-Clause
// Bytes per second through parser and telemetry decoder. `benchmark_protocol --once STREAM` runs one stream of 4 MB
// once, for callgrind.
#include <benchmark/benchmark.h>

#include <array>
#include <cstdio>
#include <cstring>
#include <string_view>

#include "host_tests/benchmark/receive.h"
#include "host_tests/property/protocol/densest_autopilot_headers.h"
#include "host_tests/property/protocol/streams.h"

namespace {

using m100::host_tests::Bytes;
using namespace m100;
using host_tests::receive;

constexpr std::size_t kStreamBytes = 4'000'000;
struct Stream {
  const char* name;
  Bytes (*make)(std::size_t);
};

constexpr std::array kStreams{
    Stream{"clean_142_byte_frames", host_tests::clean_telemetry},
    Stream{"random_bytes", host_tests::noise},
    Stream{"runs_of_start_bytes", host_tests::start_bytes},
    Stream{"headers_of_1023", host_tests::longest_headers},
    Stream{"densest_headers",
           [](std::size_t count) {
             Bytes bytes(count);
             for (std::size_t at = 0; at < count; ++at) {
               bytes[at] = host_tests::densest_autopilot_byte(at);
             }
             return bytes;
           }},
    Stream{"frames_behind_false_headers", host_tests::frames_behind_false_headers},
};

void run(benchmark::State& state, const Stream& stream) {
  const Bytes bytes = stream.make(kStreamBytes);
  protocol::FrameParser parser{protocol::kMaxAutopilotFrameBytes};
  for ([[maybe_unused]] const auto once : state) {
    benchmark::DoNotOptimize(receive(parser, bytes));
  }
  state.SetBytesProcessed(static_cast<std::int64_t>(state.iterations()) * static_cast<std::int64_t>(bytes.size()));
}

int run_once(std::string_view name) {
  for (const Stream& stream : kStreams) {
    if (name == stream.name) {
      const Bytes bytes = stream.make(kStreamBytes);
      protocol::FrameParser parser{protocol::kMaxAutopilotFrameBytes};
      const host_tests::Received result = receive(parser, bytes);
      std::printf("%s: %zu bytes, %llu frames\n", stream.name, bytes.size(),
                  static_cast<unsigned long long>(result.frames));
      return 0;
    }
  }
  std::fprintf(stderr, "no stream of that name\n");
  return 2;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 3 && std::strcmp(argv[1], "--once") == 0) {
    return run_once(argv[2]);
  }
  for (const Stream& stream : kStreams) {
    benchmark::RegisterBenchmark(stream.name, [&stream](benchmark::State& state) { run(state, stream); });
  }
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
