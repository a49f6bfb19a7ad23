// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "firmware/app/byte_tap.h"
#include "firmware/core/expected.h"
#include "firmware/core/time.h"
#include "hal/uart.h"
#include "protocol/pose_message.h"

namespace m100::app {

/// The newest pose of a tick.
struct PoseSample {
  protocol::PoseMessage message;
  core::Duration age{0};  ///< from capture to this tick: the sender's part, and the time on the line
};

/// The source of pose at the other end of a second UART. One call per tick; older messages of the same tick are passed
/// over. A message whose number is not newer than the last is refused (doubled or out of order), unless the sender
/// evidently restarted: a step back by more than kRestart, or nothing for a second.
class PoseLink {
 public:
  static constexpr std::size_t kBytesPerTick = 2048;
  static constexpr std::uint32_t kRestart = 1000;

  /// @param baud for the time a message spends on the line; 0: none.
  /// @param tap sees the received bytes; may be null.
  PoseLink(hal::Uart& uart, std::uint32_t baud, ByteTap* tap = nullptr);

  /// @returns the newest pose that came since the call before. kNotReady: none.
  core::Expected<PoseSample> receive(core::TimePoint now);

  const protocol::PoseParser::Stats& stats() const { return parser_.stats(); }
  std::uint32_t refused_sequences() const { return refused_sequences_; }
  std::uint32_t lost_messages() const { return lost_messages_; }

 private:
  bool accept(std::uint32_t sequence, core::TimePoint now);

  hal::Uart& uart_;
  core::Duration line_time_;
  ByteTap* tap_;
  protocol::PoseParser parser_;
  bool has_last_ = false;
  std::uint32_t last_sequence_ = 0;
  core::TimePoint last_time_{};
  std::uint32_t refused_sequences_ = 0;
  std::uint32_t lost_messages_ = 0;
};

}  // namespace m100::app
