// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "firmware/core/expected.h"
#include "firmware/core/pose.h"
#include "firmware/core/time.h"
#include "firmware/link/byte_tap.h"
#include "firmware/link/clock_comparison.h"
#include "hal/uart.h"
#include "protocol/mavlink/parser.h"

namespace m100::link {

struct PoseLinkStats {
  std::uint64_t poses = 0;            ///< taken
  std::uint32_t refused = 0;          ///< numbers that cannot be
  std::uint32_t refused_order = 0;    ///< doubled, or overtaken by a newer one
  std::uint32_t refused_senders = 0;  ///< of another sender than the one that is being heard
  std::uint32_t lost_frames = 0;      ///< by the numbers of the sender's frames, of any message
  std::uint32_t answers = 0;          ///< to our questions for the time
};

/// The source of pose at the other end of a second UART: MAVLink, unsigned, because a serial port is a wire. One call
/// per tick; older poses of the same tick are passed over. A pose whose stamp is not newer than the last is refused,
/// unless the sender evidently restarted: a step back by more than kRestart, or nothing for a second; until then the
/// first sender is the only one that is heard.
class PoseLink {
 public:
  static constexpr std::size_t kBytesPerTick = 2048;
  static constexpr core::SenderClock::duration kRestart = std::chrono::seconds(10);

  /// @param baud for the time a byte spends on the line; 0: none.
  /// @param tap sees all bytes of both directions; may be null.
  PoseLink(hal::Uart& uart, std::uint32_t baud, ByteTap* tap = nullptr);

  /// @returns the newest pose that came since the call before, its `captured` as the sender stamped it; where the
  /// sender
  ///   stamps nothing, when it came. kNotReady: none.
  core::Expected<core::Pose<double>> receive(core::TimePoint now);

  /// Asks the sender for its time, five times a second: 30 bytes. Once it is known, only as often as the line has had
  /// room for the answer since the last question. A sender that does not answer is flown with all the same.
  void ask_time(core::TimePoint now);

  const PoseLinkStats& stats() const { return stats_; }
  const mavlink::ParserStats& parser_stats() const { return parser_.stats(); }

 private:
  /// The newest of its kind in this call, and where in the stream it ended.
  struct Newest {
    core::Pose<double> pose;
    std::uint64_t pose_end = 0;
    std::int64_t ts1 = 0;
    std::int64_t theirs = 0;
    std::uint64_t answer_end = 0;
  };
  void take(const mavlink::FrameView& frame, core::TimePoint now, Newest& newest);
  bool accept(const core::Pose<double>& pose, core::TimePoint now);
  bool hears(const mavlink::FrameView& frame, core::TimePoint now);
  bool has_room(core::TimePoint now) const;

  hal::Uart& uart_;
  std::uint32_t baud_;
  ByteTap* tap_;
  mavlink::Parser parser_;
  ClockComparison comparison_;
  bool has_last_ = false;
  mavlink::Address sender_;
  std::uint8_t last_frame_ = 0;  ///< number of the sender's last frame
  core::SenderTime last_captured_{};
  core::TimePoint last_time_{};
  std::uint8_t questions_ = 0;
  std::uint64_t asked_at_bytes_ = 0;  ///< of the parser, at the last question
  PoseLinkStats stats_;
};

}  // namespace m100::link
