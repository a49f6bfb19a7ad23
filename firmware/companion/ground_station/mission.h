// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "firmware/companion/ground_station/goal_planner.h"
#include "protocol/mavlink/mission_messages.h"

namespace m100::companion {

/// MISSION_STATE of MAVLink.
enum class MissionState : std::uint8_t { kNone = 1, kNotStarted = 2, kActive = 3, kPaused = 4, kComplete = 5 };

/// Flies the items of a mission one after the other, as goals.
///
/// An item is reached when the reference rests and the aircraft is within the item's radius of the place (param2;
/// kRadius_m if it is 0 or not a number). An item with a radius, autocontinue and no time to hold (param1) is passed
/// without a stop: it is reached as soon as aircraft and reference are within the radius. The heading is param4 (deg,
/// clockwise from x); if it is not a number, the heading does not change. With autocontinue 0 the mission pauses after
/// the item, if another follows.
///
/// The mission also pauses at another goal, at an order to hold, when control ends, and in every state of the failsafe
/// but kNominal and kCoast. It continues only on an order, towards the item that was not reached.
template <typename T>
class Mission {
 public:
  static constexpr double kRadius_m = 0.5;
  using Items = std::span<const mavlink::MissionItemInt>;

  explicit Mission(GoalPlanner<T>& goals) : goals_(goals) {}

  /// @param last item to fly; if it does not come after the first, or does not exist, all remaining ones are flown.
  /// @returns false: there is no such item, or the law does not fly.
  bool start(Items items, std::uint16_t first, std::uint16_t last, core::TimePoint now, bool flies);
  /// Whether the mission is active as such an order would start it: the order is repeated because its answer was lost.
  bool is_active_as(Items items, std::uint16_t first, std::uint16_t last) const {
    return state_ == MissionState::kActive && first == first_ && last_of(items, first, last) == last_;
  }
  /// @returns false: no mission is paused, or the law does not fly.
  bool resume(Items items, core::TimePoint now, bool flies);
  /// Pauses because something else moves the reference now; does not brake it.
  void pause();
  /// Call it when the items have changed: resets the mission.
  void reset(Items items);
  /// Call it after each tick. @returns the item that was reached in it.
  std::optional<std::uint16_t> update(Items items, core::TimePoint now, const est::Estimate<T>& estimate, bool flies);

  MissionState state() const { return state_; }
  /// The item that is flown to, or would be flown to next.
  std::uint16_t current() const { return current_; }

 private:
  void fly_to_item(const mavlink::MissionItemInt& item, core::TimePoint now);
  bool is_reached(const mavlink::MissionItemInt& item, core::TimePoint now, const est::Estimate<T>& estimate) const;
  void advance(Items items, core::TimePoint now);
  static std::uint16_t last_of(Items items, std::uint16_t first, std::uint16_t last) {
    return last > first && last < items.size() ? last : static_cast<std::uint16_t>(items.size() - 1);
  }

  GoalPlanner<T>& goals_;
  MissionState state_ = MissionState::kNone;
  std::uint16_t current_ = 0;
  std::uint16_t first_ = 0;  ///< item with which it was started
  std::uint16_t last_ = 0;
  std::optional<core::TimePoint> reached_at_;
};

/// The place of an item, in the world of the pose. @param yaw_rad heading if the item has none of its own.
template <typename T>
ref::Waypoint<T> place_of(const mavlink::MissionItemInt& item, T yaw_rad);

extern template class Mission<float>;
extern template class Mission<double>;

}  // namespace m100::companion
