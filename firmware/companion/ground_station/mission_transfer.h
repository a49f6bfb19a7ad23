// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "firmware/companion/ground_station/requests.h"
#include "firmware/core/time.h"

namespace m100::companion {

// Results of MAVLink's mission protocol (MAV_MISSION_RESULT) that are used here.
namespace mission_result {
inline constexpr std::uint8_t kAccepted = 0;
inline constexpr std::uint8_t kUnsupportedFrame = 2;
inline constexpr std::uint8_t kUnsupported = 3;
inline constexpr std::uint8_t kNoSpace = 4;
inline constexpr std::uint8_t kInvalidParam1 = 6;
inline constexpr std::uint8_t kInvalidParam2 = 7;
inline constexpr std::uint8_t kInvalidParam3 = 8;
inline constexpr std::uint8_t kInvalidParam4 = 9;
inline constexpr std::uint8_t kInvalidX = 10;
inline constexpr std::uint8_t kInvalidY = 11;
inline constexpr std::uint8_t kInvalidZ = 12;
inline constexpr std::uint8_t kInvalidSequence = 13;
inline constexpr std::uint8_t kDenied = 14;
inline constexpr std::uint8_t kCancelled = 15;
}  // namespace mission_result

/// Whether an item can be flown here: NAV_WAYPOINT in LOCAL_NED, at most 1 km away on each axis, its numbers in their
/// ranges. @returns one of mission_result.
std::uint8_t validate(const mavlink::MissionItemInt& item);

/// Converts an item to the newer message. A coordinate that is not a number, or too far away for a flight, becomes one
/// that validate() refuses.
mavlink::MissionItemInt to_item_int(const mavlink::MissionItem& item);

/// The vehicle's end of MAVLink's mission protocol: accepts a list of items from any sender that announces one, one
/// transfer at a time, and sends the list on request. An incomplete list replaces nothing. A missing item is requested
/// again; a stalled transfer is abandoned. Bounded, no heap, no clock: a log replays it from the pose port's bytes.
class MissionTransfer {
 public:
  static constexpr std::size_t kMaxItems = 100;
  static constexpr core::Duration kRetryInterval = std::chrono::milliseconds(250);
  static constexpr std::uint32_t kMaxRequestsPerItem = 40;  ///< requests for one item

  /// @param is_flown the items are being flown: they can be read, but neither replaced nor cleared, and a transfer that
  /// began before ends at its next item.
  void receive(const Request& request, bool is_flown, core::TimePoint now, Replies& replies);
  /// Call it in every tick, after receive().
  void tick(core::TimePoint now, Replies& replies);

  /// The newest complete list.
  std::span<const mavlink::MissionItemInt> items() const { return std::span(lists_[current_]).first(count_); }
  /// Grows with each list that was completed or cleared.
  std::uint32_t edition() const { return edition_; }
  bool is_open() const { return expected_ != 0; }

 private:
  void take(const mavlink::MissionCount& announced, mavlink::Address from, bool is_flown, core::TimePoint now,
            Replies& replies);
  void take(const mavlink::MissionItemInt& item, mavlink::Address from, bool is_flown, core::TimePoint now,
            Replies& replies);
  void send_item(const mavlink::MissionRequestInt& asked, mavlink::Address to, Replies& replies) const;
  void request_item(core::TimePoint now, Replies& replies);
  void send_count(const mavlink::MissionRequestList& list, mavlink::Address from, Replies& replies) const;
  void clear(const mavlink::MissionClearAll& erased, mavlink::Address from, bool is_flown, Replies& replies);
  void replace(std::size_t count);
  void finish(const mavlink::MissionItemInt& item, std::uint8_t result, Replies& replies);

  std::array<std::array<mavlink::MissionItemInt, kMaxItems>, 2> lists_{};
  std::size_t current_ = 0;  ///< index of the valid list of the two
  std::size_t count_ = 0;
  std::uint32_t edition_ = 0;
  // State of the open transfer.
  std::uint16_t expected_ = 0;  ///< number of items; 0: no transfer is open
  std::uint16_t next_ = 0;
  mavlink::Address partner_{};
  core::TimePoint requested_at_{};
  std::uint32_t request_count_ = 0;
  /// How the newest transfer ended, and with which item. A sender that repeats that item gets the answer again.
  struct TransferResult {
    std::uint16_t seq;
    std::uint8_t result;
  };
  std::optional<TransferResult> end_;
};

}  // namespace m100::companion
