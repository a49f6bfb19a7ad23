// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <variant>

#include "firmware/core/expected.h"
#include "firmware/core/time.h"
#include "firmware/ctl/command.h"
#include "firmware/vrc/sticks.h"
#include "protocol/dji/commands.h"

namespace m100::link {

/// How commands reach the autopilot.
enum class Channel : std::uint8_t {
  kVirtualRc,  ///< stick counts, as in the paper
  kMovement,   ///< flag 0x0A: angle, vertical velocity, yaw rate, body frame
};

/// A command for one of the two channels.
using ChannelCommand = std::variant<vrc::Sticks, ctl::Command<double>>;

struct ChannelConfig {
  Channel channel = Channel::kVirtualRc;
  /// 0: the default of the channel (25 or 50 Hz). Virtual RC takes 5..25 Hz, movement control 1..50 Hz.
  double rate_hz = 0.0;
  /// True: the rate of the paper, 100 Hz on either channel, beyond what DJI allows; rate_hz is then not used.
  bool paper_100_hz = false;
};

/// Time between two commands.
/// @returns kOutOfRange: the rate is outside the window of its channel.
core::Expected<core::Duration> command_period(const ChannelConfig& config);

/// Limits the command rate. Due times lie on a grid, so that clock jitter hardly lowers the mean rate and never raises
/// it. Two commands are never closer than period - kSlack, and a pause is not made up for. At 50 Hz or less, no window
/// of one second holds more commands than 1 s / period, rounded up.
class RateLimiter {
 public:
  static constexpr core::Duration kSlack = std::chrono::milliseconds(2);
  static constexpr core::Duration kWindow = std::chrono::seconds(1);
  /// DJI's maximum per second, on any channel; at a faster rate (the paper's) only the spacing is limited.
  static constexpr std::size_t kMaxPerWindow = 50;

  explicit RateLimiter(core::Duration period)
      : period_(period), per_window_(static_cast<std::size_t>((kWindow + period - core::Duration{1}) / period)) {}

  bool due(core::TimePoint now) const {
    return now >= next_ - kSlack && (!used_ || now - last_ >= period_ - kSlack) && window_has_room(now);
  }
  /// Call it for each command that is passed to the line.
  void sent(core::TimePoint now) {
    const core::TimePoint on_grid = next_ + period_;
    const core::TimePoint from_now = now + period_ - kSlack;
    next_ = used_ && on_grid > from_now ? on_grid : now + period_;
    newest_ = (newest_ + 1) % kMaxPerWindow;
    count_ += count_ < kMaxPerWindow ? 1U : 0U;
    used_ = true;
    left(now);
  }
  /// Call it when the last byte of that command has left: only then was it sent.
  void left(core::TimePoint now) {
    last_ = now;
    times_[newest_] = now;
  }
  core::Duration period() const { return period_; }

 private:
  bool window_has_room(core::TimePoint now) const {
    if (per_window_ > kMaxPerWindow || count_ < per_window_) {
      return true;
    }
    return now - times_[(newest_ + kMaxPerWindow + 1 - per_window_) % kMaxPerWindow] >= kWindow;
  }

  core::Duration period_;
  std::size_t per_window_;
  core::TimePoint next_{};
  core::TimePoint last_{};
  bool used_ = false;
  std::array<core::TimePoint, kMaxPerWindow> times_{};  ///< of the last commands, in a ring
  std::size_t newest_ = 0;
  std::size_t count_ = 0;
};

/// Sticks as sixteen channels: gear down, mode A (the mode the paper's model was identified in), the rest centred.
protocol::VirtualRcData to_virtual_rc(const vrc::Sticks& sticks);

/// Converts FLU and SI to DJI's movement command: degrees, nose up and clockwise positive, up positive. Saturated at
/// the command's ranges; the encoder refuses numbers that are not finite.
protocol::Movement to_movement(const ctl::Command<double>& command);

}  // namespace m100::link
