// SPDX-License-Identifier: BSD-3-Clause
// flight_hash RECORDING: replays a flight and prints its SHA-256 for each scalar type (promise R6).
#include <cstdio>
#include <fstream>
#include <memory>

#include "host_tests/golden/flight/flight_recording.h"

namespace {

template <typename T, typename S>
bool print_hash(const char* name, const char* path) {
  std::ifstream file(path, std::ios::binary);
  const auto read = [&file](std::span<std::byte> into) {
    file.read(reinterpret_cast<char*>(into.data()), static_cast<std::streamsize>(into.size()));
    return static_cast<std::size_t>(file.gcount());
  };
  const auto flight = std::make_unique<m100::golden::ReplayedFlight<T, S>>();
  const auto tick = std::make_unique<m100::golden::RecordedTick>();
  unsigned ticks = 0;
  while (m100::golden::read_tick(*tick, read)) {
    flight->load(*tick);
    flight->tick();
    flight->drain();
    ++ticks;
  }
  const m100::golden::HashText text = flight->finish();
  std::printf("%-6s %.64s %u ticks\n", name, text.data(), ticks);
  return ticks > 0 && text[0] != '\0';
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: flight_hash RECORDING\n");
    return 2;
  }
  const bool complete = print_hash<double, double>("double", argv[1]) && print_hash<float, float>("float", argv[1]) &&
                        print_hash<float, m100::core::Fixed>("fixed", argv[1]);
  return complete ? 0 : 1;
}
