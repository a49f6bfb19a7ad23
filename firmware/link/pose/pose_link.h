// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "firmware/core/expected.h"
#include "firmware/core/fence.h"
#include "firmware/core/pose.h"
#include "firmware/core/time.h"
#include "firmware/link/byte_tap.h"
#include "firmware/link/pose/clock_comparison.h"
#include "firmware/link/pose/pose_fault.h"
#include "firmware/link/pose/pose_senders.h"
#include "firmware/link/pose/stamp_order.h"
#include "firmware/link/pose/stamp_unit.h"
#include "hal/uart.h"
#include "protocol/mavlink/parser.h"
#include "protocol/mavlink/pose_messages.h"

namespace m100::link {

struct PoseLinkStats {
  std::uint64_t poses = 0;                          ///< accepted
  std::uint32_t refused = 0;                        ///< for numbers, frame of ODOMETRY, or unit of the time stamps
  std::uint32_t refused_order = 0;                  ///< by StampOrder
  std::uint32_t refused_senders = 0;                ///< from another sender than the accepted one
  std::uint32_t lost_frames = 0;                    ///< by the sequence numbers of the sender's frames, of any message
  std::uint32_t answers = 0;                        ///< to our time requests
  std::uint32_t announced_jumps = 0;                ///< changes of the sender's reset_counter, by accepted poses
  std::array<std::uint32_t, kPoseFaults> faults{};  ///< all refused poses, by the reason
  PoseFault last_fault = PoseFault::kNone;
  core::TimePoint last_fault_at{};
  double last_variance_m2 = 0.0;  ///< the largest that the newest pose states
};

/// From the centre of gravity to the origin of the pose: forward, left, up of the body (FLU) [m].
using LeverArm = std::array<float, 3>;

/// What the operator states of the poses, and how exact they must be.
struct PoseProperties {
  LeverArm offset_b_m{};
  /// Of each axis, stated by the operator for a source whose covariance means nothing; 0: the sender's variance counts.
  double sigma_m = 0.0;
  /// Along each axis of the world: a pose that states more is refused.
  std::array<double, 3> max_variance_m2{1e12, 1e12, 1e12};

  /// The largest variance that can be flown inside a fence: from its middle, three sigmas
  /// (est::EstimateStatus::error_m) reach neither side.
  static constexpr PoseProperties inside(const core::Fence& fence, double sigma_m, const LeverArm& offset_b_m = {}) {
    PoseProperties properties{.offset_b_m = offset_b_m, .sigma_m = sigma_m};
    for (std::size_t axis = 0; axis < fence.side.size(); ++axis) {
      const double largest_sigma_m = (fence.side[axis].high_m - fence.side[axis].low_m) / (2.0 * 3.0);
      properties.max_variance_m2[axis] = largest_sigma_m * largest_sigma_m;
    }
    return properties;
  }
};

/// The source of pose at the other end of a second UART, in MAVLink. (With a signing key the UART is a SignedLine.) One
/// call per tick returns the newest pose only. A pose whose time stamp is not newer than the last is refused, unless
/// StampOrder shows that the sender's clock was set. Only the chosen sender is accepted; without a choice, the first
/// one until no pose of it was accepted for a second. All that is handed on is the motion of the centre of gravity: the
/// lever arm, turned by the attitude of the same pose, is subtracted. A time request of the sender is answered.
class PoseLink {
 public:
  static constexpr std::size_t kBytesPerTick = 2048;

  /// @param baud gives the time of a byte on the line; 0: none.
  /// @param tap sees all bytes of both directions; may be null.
  PoseLink(hal::Uart& uart, std::uint32_t baud, ByteTap* tap = nullptr, SenderChoice choice = {},
           const PoseProperties& properties = {});

  /// @returns the newest pose that arrived since the last call; `captured` is the sender's time stamp, or the time of
  ///   arrival if the sender does not stamp. kNotReady: none.
  core::Expected<core::Pose<double>> receive(core::TimePoint now);

  /// Asks the sender for its time, at most five times a second, with at most 30 bytes. Once the time is known, it asks
  /// only if the line has had spare capacity for the answer since the last request.
  void request_time(core::TimePoint now);

  const PoseLinkStats& stats() const { return stats_; }
  const PoseSenders& senders() const { return senders_; }
  mavlink::Address sender() const { return sender_; }  ///< whose poses are used
  /// A second sender that sent poses within PoseSenders::kRecent. null: none, no pose used yet, or the operator chose.
  const PoseSenders::Sender* rival(core::TimePoint now) const {
    return choice_.is_made() || !has_last_ ? nullptr : senders_.other_than(sender_, now);
  }
  /// The world's up in the body (FLU) by the attitude of the poses, mean of about the last 16; zero before the first.
  const core::Vector<float, 3>& up_b() const { return up_b_; }
  const mavlink::ParserStats& parser_stats() const { return parser_.stats(); }

 private:
  /// The newest pose and the newest time answer of this call, and where in the stream each ended.
  struct Newest {
    core::Pose<double> pose;
    std::uint64_t pose_end = 0;
    std::int64_t ts1 = 0;
    std::int64_t theirs = 0;
    std::uint64_t answer_end = 0;
    std::optional<std::int64_t> question_ts1;  ///< of the sender's newest time request
  };
  void take(const mavlink::FrameView& frame, core::TimePoint now, Newest& newest);
  void refuse(PoseFault fault, core::TimePoint now);
  bool accept(const core::Pose<double>& pose, std::uint8_t frame, core::TimePoint now);
  void count_jump(std::optional<std::uint8_t> counter, bool is_same_sender);
  core::Vector<double, 3> stated_variance_m2(const core::Pose<double>& pose);
  bool is_from_sender(const mavlink::FrameView& frame, core::TimePoint now);
  bool has_room(core::TimePoint now) const;
  void send(const mavlink::Timesync& message, core::TimePoint now);

  hal::Uart& uart_;
  std::uint32_t baud_;
  ByteTap* tap_;
  mavlink::Parser parser_;
  ClockComparison comparison_;
  SenderChoice choice_;
  PoseProperties properties_;
  PoseSenders senders_;
  bool has_last_ = false;
  mavlink::Address sender_;
  /// Of the sender: the number of its last frame, and the counter in its last pose.
  struct {
    std::uint8_t frame = 0;
    std::optional<std::uint8_t> reset_counter;  ///< none yet
  } last_;
  core::TimePoint last_time_{};
  StampOrder order_;
  StampUnit unit_;
  core::Vector<float, 3> up_b_ = core::Vector<float, 3>::Zero();
  bool is_stamped_ = false;     ///< the last pose had a time stamp
  bool clock_was_set_ = false;  ///< since the last pose that was handed on
  struct TimeMessages {
    std::uint8_t count = 0;
    std::uint64_t last_at_bytes = 0;  ///< of the parser, at the last request
  } time_messages_;
  PoseLinkStats stats_;
};

}  // namespace m100::link
