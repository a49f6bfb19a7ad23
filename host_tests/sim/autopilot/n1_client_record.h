// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware/core/time.h"
#include "host_tests/sim/autopilot/n1_event_log.h"

namespace m100::sim {

/// Counters for a strict check of the client.
struct N1Record {
  std::uint32_t obtain_requests = 0;
  core::Duration min_obtain_spacing = core::Duration::max();
  std::uint32_t virtual_rc_on_requests = 0;
  core::Duration min_on_spacing = core::Duration::max();
  std::uint32_t movement_taken = 0;
  std::uint32_t movement_ignored = 0;
  std::uint32_t virtual_rc_taken = 0;
  std::uint32_t virtual_rc_ignored = 0;
  std::uint32_t max_commands_per_s = 0;  ///< of one channel, in any second
  std::uint32_t losses = 0;              ///< of authority while the client had it
  std::uint32_t control_after_loss = 0;  ///< control frames of a channel that arrived after the loss of authority
  core::Duration latest_after_loss{0};   ///< the longest time from the loss to such a frame
  std::uint32_t telemetry_packages = 0;
  std::uint32_t bad_commands = 0;  ///< wrong size, unknown, or a number that is not finite
};

/// Watches the client: the spacing of its requests, the rate of its control frames, and what it sends after a loss of
/// authority.
class N1ClientRecord {
 public:
  /// "On" sent sooner than this makes the autopilot ignore its own mode switch for a while (protocol, 7).
  static constexpr core::Duration kSwitchSpacing = std::chrono::seconds(2);

  explicit N1ClientRecord(const N1EventLog& log) : log_(log) {}
  N1Record& counts() { return record_; }
  const N1Record& counts() const { return record_; }

  void count_obtain_request();
  /// @returns whether "on" came too soon after the last.
  bool count_virtual_rc_on_request();
  /// Count a control frame. @param obeyed whether the channel is the client's.
  void count_virtual_rc_frame(bool obeyed);
  void count_movement_frame(bool obeyed);
  void count_loss(bool client_commanded);
  /// Authority is the client's again, or was given back and not taken.
  void clear_loss() { authority_lost_ = false; }

 private:
  /// Times of the last commands of one channel, for the count in any second.
  class RateCounter {
   public:
    std::uint32_t count(core::TimePoint now);

   private:
    static constexpr std::size_t kDepth = 256;
    std::array<core::TimePoint, kDepth> times_{};
    std::size_t count_ = 0;
  };
  void count_control_frame(std::uint32_t per_s, bool obeyed);

  const N1EventLog& log_;
  N1Record record_;
  core::TimePoint last_obtain_{};
  core::TimePoint last_on_{};
  bool authority_lost_ = false;
  core::TimePoint lost_at_{};
  RateCounter movement_rate_;
  RateCounter virtual_rc_rate_;
};

}  // namespace m100::sim
