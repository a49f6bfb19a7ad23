// SPDX-License-Identifier: BSD-3-Clause
// kept_flights FOLDER: flies the recordings of the folder and prints the table of their hashes (kept.txt).
#include <cstdio>

#include "host_tests/golden/flight/kept_flights.h"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: kept_flights FOLDER\n");
    return 2;
  }
  std::printf(
      "# Flight, scalar, then one word a second: eight digits of the log's hash, eight of what no log has.\n"
      "# Written by `kept_flights host_tests/golden/flight/kept` (a target of host-release) after a change that is "
      "meant.\n"
      "# The recordings were recorded by `record_kept`; they need to be recorded again only when the protocol "
      "changes.\n");
  for (const m100::golden::KeptFlight& kept : m100::golden::kKeptFlights) {
    for (const std::string& line : m100::golden::lines_of(kept, argv[1])) {
      std::printf("%s\n", line.c_str());
    }
  }
  return 0;
}
