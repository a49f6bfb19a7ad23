// SPDX-License-Identifier: BSD-3-Clause
// Writes the kept corpus of the log readers: make_log_corpus host_tests/fuzz/log_corpus
#include <cstdio>
#include <fstream>
#include <map>
#include <string>

#include "host_tests/unit/logs/log_samples.h"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: make_log_corpus DIRECTORY\n");
    return 2;
  }
  const std::map<std::string, char> readers{{"csv", 0},       {"mat", 1},    {"matz", 1},   {"ulog", 2},
                                            {"ardupilot", 3}, {"rosbag", 4}, {"rosbag2", 5}};
  const auto write = [&](const std::string& name, char reader, const std::string& bytes) {
    std::ofstream(std::string(argv[1]) + "/" + name, std::ios::binary) << reader << bytes;
  };
  for (const auto& [name, bytes] : m100::lab::logs::log_samples("corpus")) {
    write(name, readers.at(name), bytes);
  }
  write("map", 7,
        "frame = \"ned_frd\"\ntime = { column = \"t\", scale = 1e-3 }\n[signals]\nattitude_roll = \"a\"\n"
        "rate_x = { column = \"b\", offset = 1, sequence = \"i\", time = \"u\" }\n[extra]\nbattery = \"v\"\n");
  return 0;
}
