// SPDX-License-Identifier: BSD-3-Clause
// Writes the kept corpus with our own encoder: make_fuzz_corpus host_tests/fuzz/corpus
#include <algorithm>
#include <cstdio>
#include <fstream>

#include "host_tests/property/protocol/every_message.h"

int main(int argc, char** argv) {
  using namespace m100::host_tests;
  if (argc != 2) {
    std::fprintf(stderr, "usage: make_fuzz_corpus DIRECTORY\n");
    return 2;
  }
  const auto write = [&](std::string name, const Bytes& bytes) {
    std::replace(name.begin(), name.end(), ' ', '_');
    std::ofstream file(std::string(argv[1]) + "/" + name, std::ios::binary);
    file.put('\x07');  // sets portions of 36 bytes
    file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  };
  for (const NamedFrame& message : every_message()) {
    if (message.name.starts_with("plain") || message.name == "empty ack") {
      write(message.name, message.bytes);
    }
  }
  for (unsigned seed = 0; seed < 4; ++seed) {
    std::mt19937 random(seed);
    Bytes stream = damaged_stream(8, random);
    stream.resize(std::min<std::size_t>(stream.size(), 1200));
    write("damaged stream " + std::to_string(seed), stream);
  }
  return 0;
}
