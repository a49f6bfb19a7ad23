// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "protocol/dji/frame_parser.h"
#include "protocol/dji/telemetry.h"

namespace m100::host_tests {

inline constexpr std::size_t kReadBytes = 4096;  ///< what a serial driver hands over at once, at most

struct Received {
  std::uint64_t frames = 0;
  float sum = 0.F;  ///< of something in them, so that nothing is optimised away
};

/// Feeds a stream through parser and telemetry decoder. Not inlined, because callgrind counts it by its name.
[[gnu::noinline]] inline Received receive(protocol::FrameParser& parser, std::span<const std::byte> stream) {
  Received result;
  protocol::Telemetry telemetry;
  while (!stream.empty()) {
    const std::size_t count = std::min(stream.size(), kReadBytes);
    parser.consume(stream.first(count), [&](const protocol::FrameView& frame) {
      if (frame.data.size() > 2 && decode_telemetry(frame.data.subspan(2), telemetry) == core::Status::kOk) {
        result.sum += telemetry.attitude[0];
        ++result.frames;
      }
    });
    stream = stream.subspan(count);
  }
  return result;
}

}  // namespace m100::host_tests
