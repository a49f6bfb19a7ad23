// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string_view>

#include "firmware/core/pose.h"
#include "firmware/core/time.h"
#include "firmware/link/false_header_detector.h"
#include "firmware/log/ulog_writer.h"
#include "protocol/cipher.h"
#include "protocol/dji/frame_parser.h"
#include "protocol/dji/session.h"
#include "protocol/dji/telemetry.h"

namespace m100::companion {

/// Converts time stamps of another clock (the autopilot's, the pose sender's) to ours. Arrival times have a jitter; the
/// time stamps have none. The offset between the clocks is the smallest one seen, and may grow as fast as two crystals
/// drift apart. So the converted time stamps nearly keep their original spacing.
class ClockFit {
 public:
  /// @param own time stamp, by the other clock. @param arrived its arrival on our clock.
  /// @returns the time of the stamp on our clock, with the shortest delay seen taken as zero; not after `arrived`, and
  ///   never before the last result.
  core::TimePoint to_our_clock(core::Duration own, core::TimePoint arrived) {
    const core::Duration offset = arrived.time_since_epoch() - own;
    if (offset_ && std::max(offset - *offset_, *offset_ - offset) > kJump) {
      offset_.reset();
      ++restarts_;
    }
    const core::Duration drift = (arrived - last_arrived_) / kDriftShare;
    offset_ = offset_ ? std::min(offset, *offset_ + drift) : offset;
    last_arrived_ = arrived;
    last_ = std::max(last_, core::TimePoint{own + *offset_});
    return last_;
  }
  /// Number of jumps of more than a second: the other side restarted, or its clock was set.
  std::uint32_t restarts() const { return restarts_; }

 private:
  static constexpr core::Duration kJump = std::chrono::seconds(1);
  static constexpr int kDriftShare = 5000;  ///< 200 ppm: two crystals of 100 ppm

  std::optional<core::Duration> offset_;
  core::TimePoint last_arrived_{};
  core::TimePoint last_{};
  std::uint32_t restarts_ = 0;
};

/// Writes an autopilot's telemetry, and poses, as records of a log. It never sends anything.
class Recorder {
 public:
  /// The recorded streams, in the order of the log's topics.
  enum Stream : std::size_t { kRc, kAttitude, kRates, kVelocity, kForce, kPosition, kStatus, kPose, kStreams };
  static std::string_view name(Stream stream);

  struct StreamStatistics {
    std::uint64_t samples = 0;
    core::TimePoint first{};
    core::TimePoint last{};
    core::Duration longest_gap{0};
    std::uint32_t gaps = 0;  ///< longer than 50 ms and than 3.5 mean intervals (after ten samples): a fit omits them
    double rate_hz() const;
    void add(core::TimePoint at);
    /// Ends the recording: a stream that stopped before has a gap until here.
    void end(core::TimePoint at);

   private:
    void note_gap(core::Duration gap);
  };

  /// The travel of a stick, in counts from the middle.
  struct StickRange {
    double min_counts = std::numeric_limits<double>::infinity();
    double max_counts = -std::numeric_limits<double>::infinity();
  };

  /// @param cipher of the app's key, if the autopilot encrypts its telemetry; null: none.
  Recorder(log::UlogWriter& log, std::uint32_t baud, const protocol::Cipher* cipher);

  /// Writes header and formats of the log. @returns as UlogWriter::begin().
  core::Status begin(core::TimePoint now, std::span<const log::Note> notes);
  /// Takes bytes of the autopilot's port.
  void take(std::span<const std::byte> bytes, core::TimePoint now);
  /// Call it in every cycle, also if nothing came: a false header must not hold good frames back.
  void reject_false_frames(core::TimePoint now);
  void take(const core::Pose<double>& pose);
  /// Call it once, at the end of the recording.
  void end(core::TimePoint now);

  const StreamStatistics& statistics(Stream stream) const { return statistics_[stream]; }
  /// roll, pitch, throttle, yaw
  const std::array<StickRange, 4>& sticks() const { return sticks_; }
  const protocol::ParserStats& parser() const { return parser_.stats(); }
  std::uint32_t packages() const { return packages_; }
  std::uint32_t bad_packages() const { return bad_packages_; }
  std::uint32_t undecipherable() const { return undecipherable_; }
  std::uint32_t restarts() const { return clock_.restarts(); }
  /// Packages in which a computer had control, or Virtual RC was on: their sticks may not be the pilot's.
  std::uint32_t computer_packages() const { return computer_packages_; }

 private:
  void handle(const protocol::FrameView& frame, core::TimePoint now);
  void write_package(core::TimePoint arrived);
  void write_sticks(std::uint64_t stamp_us);
  void write_motion(std::uint64_t stamp_us);
  void write_rest(std::uint64_t stamp_us);
  template <typename Record>
  void write(Stream stream, const Record& record);

  log::UlogWriter& log_;
  const protocol::Cipher* cipher_;
  protocol::FrameParser parser_{protocol::kMaxAutopilotFrameBytes};
  link::FalseHeaderDetector candidates_;
  protocol::CipherScratch scratch_{};
  protocol::Telemetry telemetry_;
  ClockFit clock_;
  ClockFit pose_clock_;
  std::array<StreamStatistics, kStreams> statistics_{};
  std::array<StickRange, 4> sticks_{};
  std::uint32_t packages_ = 0;
  std::uint32_t bad_packages_ = 0;
  std::uint32_t undecipherable_ = 0;
  std::uint32_t computer_packages_ = 0;
};

}  // namespace m100::companion
