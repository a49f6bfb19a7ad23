// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "firmware/link/line_time.h"
#include "protocol/dji/frame_parser.h"

namespace m100::link {

/// Detects that the parser waits for the rest of a frame whose header is false: the parser has no clock, so a dozen
/// false bytes could hold telemetry back until as many bytes as they claim have come.
class FalseHeaderDetector {
 public:
  explicit FalseHeaderDetector(std::uint32_t baud) : baud_(baud) {}

  /// @param adapter_delay longest delay of bytes between the line and this program.
  /// @returns true: give the header up, the rest of its frame is overdue.
  bool is_false(const protocol::FrameParser& parser, core::TimePoint now, core::Duration adapter_delay) {
    const std::size_t claimed = parser.claimed_bytes();
    if (claimed == 0) {
      return false;
    }
    if (!seen_ || parser.candidate_offset() != offset_) {
      seen_ = true;
      offset_ = parser.candidate_offset();
      since_ = now;
    }
    return now - since_ > line_time(claimed, baud_) + adapter_delay;
  }

 private:
  std::uint32_t baud_;
  bool seen_ = false;
  std::uint64_t offset_ = 0;
  core::TimePoint since_{};
};

}  // namespace m100::link
