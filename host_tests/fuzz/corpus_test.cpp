// SPDX-License-Identifier: BSD-3-Clause
// Runs the kept corpus without a fuzzer, so that earlier findings are tried again with every compiler.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

#include "host_tests/fuzz/receive.h"
#include "host_tests/property/protocol/every_message.h"
#include "protocol/dji/frame_parser.h"

namespace m100::host_tests {
namespace {

TEST(FuzzCorpus, IsReceivedWithoutContradiction) {
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator("host_tests/fuzz/corpus")) {
    SCOPED_TRACE(entry.path().string());
    std::ifstream file(entry.path(), std::ios::binary);
    const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
    receive_everything(std::as_bytes(std::span(bytes)));
    ++files;
  }
  EXPECT_GE(files, 20U);
}

// Catches a mutator that repairs no checksum: nothing that it makes would get past the parser.
TEST(FuzzCorpus, MutatorRepairsABrokenFrame) {
  for (const NamedFrame& message : every_message()) {
    Bytes broken = message.bytes;
    broken[8] ^= std::byte{1};
    broken.back() ^= std::byte{1};
    repair_frames(broken, ~std::uint64_t{0});
    protocol::FrameParser parser;
    std::size_t found = 0;
    parser.consume(broken, [&](const protocol::FrameView&) { ++found; });
    EXPECT_GE(found, 1U) << message.name;
  }
}

}  // namespace
}  // namespace m100::host_tests
