// SPDX-License-Identifier: BSD-3-Clause
// Uses the parser alone: it finds the frames in a stream that begins in the middle of a frame and is damaged in one
// place.
#include <array>
#include <cstddef>
#include <cstdio>
#include <vector>

#include "protocol/dji/frame_encoder.h"
#include "protocol/dji/frame_parser.h"

int main() {
  namespace protocol = m100::protocol;
  std::vector<std::byte> line{std::byte{0xAA}, std::byte{0x07}};  // the end of a frame that was cut off
  for (std::uint16_t number = 1; number <= 3; ++number) {
    std::array<std::byte, 64> space{};
    const std::array value{std::byte{0x42}, static_cast<std::byte>(number)};
    const protocol::MessageId id{};
    const auto frame = protocol::encode_frame({.sequence = number}, &id, value, space);
    if (!frame) {
      return 1;
    }
    line.insert(line.end(), frame->begin(), frame->end());
  }
  line[line.size() / 2] ^= std::byte{0x10};  // damages the second frame

  protocol::FrameParser parser;
  unsigned seen = 0;
  parser.consume(line, [&](const protocol::FrameView& frame) {
    std::printf("frame %u of %zu bytes at offset %llu\n", static_cast<unsigned>(frame.header.sequence),
                frame.bytes.size(), static_cast<unsigned long long>(frame.offset));
    seen = 10 * seen + frame.header.sequence;
  });
  std::printf("%llu bytes dropped\n", static_cast<unsigned long long>(parser.stats().bytes_dropped));
  return seen == 13 ? 0 : 1;  // frames 1 and 3 are found
}
