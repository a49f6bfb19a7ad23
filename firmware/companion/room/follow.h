// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "firmware/app/flight_controller.h"
#include "firmware/companion/room/goals.h"
#include "firmware/companion/room/mission.h"
#include "firmware/companion/room/mission_transfer.h"
#include "firmware/companion/room/overheard_line.h"

namespace m100::companion {

// Commands of MAVLink's common message set that are obeyed here, beside those of the overheard line.
inline constexpr std::uint16_t kMissionStart = 300;  ///< MAV_CMD_MISSION_START: param1 first item, param2 last
inline constexpr std::uint16_t kLand = 21;           ///< MAV_CMD_NAV_LAND: the autopilot lands, where it is
inline constexpr std::uint16_t kTakeOff = 22;        ///< MAV_CMD_NAV_TAKEOFF: the autopilot takes off

/// The requests of one tick and their outcome.
struct Followed {
  std::optional<GoalAnswer> goal;
  std::optional<OverheardLine::Order> order;
  bool done = false;                     ///< the order for goals or mission was carried out, or was already
  std::optional<std::uint16_t> reached;  ///< item of the mission
  bool new_items = false;                ///< a list of items is complete, or was cleared
  Replies replies;                       ///< of the mission protocol
};

constexpr bool asks_to_hold(const mavlink::CommandLong& order) {
  return order.command == kPauseContinue && order.param1 < 0.5F;
}
constexpr bool asks_to_go_on(const mavlink::CommandLong& order) {
  return order.command == kPauseContinue && order.param1 >= 0.5F;
}

/// The goals that the room sends: one at a time, or several as a mission.
template <typename T>
class Errands {
 public:
  Errands(ref::Trajectory<T>& trajectory, const core::Fence& fence, const ref::SpeedLimits& limits)
      : goals_(trajectory, fence, limits), mission_(goals_) {}
  Errands(const Errands&) = delete;
  Errands& operator=(const Errands&) = delete;

  /// Call it after each tick: messages that came over the pose port change the trajectory from the next tick. It does
  /// the same in flight and in a replay. Engaging and releasing are left to the caller: the log holds them as orders.
  template <typename S>
  Followed follow(OverheardLine& line, const app::FlightController<T, S>& controller, core::TimePoint now);

  const Goals<T>& goals() const { return goals_; }
  const Mission<T>& mission() const { return mission_; }
  std::span<const mavlink::MissionItemInt> items() const { return transfer_.items(); }

 private:
  void hear_requests(OverheardLine& line, core::TimePoint now, Followed& followed);
  /// @returns whether the order was carried out.
  bool obey(const mavlink::CommandLong& order, core::TimePoint now, bool flies);

  Goals<T> goals_;
  MissionTransfer transfer_;
  Mission<T> mission_;
};

template <typename T>
template <typename S>
Followed Errands<T>::follow(OverheardLine& line, const app::FlightController<T, S>& controller, core::TimePoint now) {
  const safety::Rung rung = controller.supervisor().rung();
  const bool flies =
      controller.link().authority().in_control && (rung == safety::Rung::kNominal || rung == safety::Rung::kCoast);
  goals_.watch(now, safety::passes_law(rung), controller.started(), controller.estimate());
  Followed followed;
  followed.order = line.take_order();
  hear_requests(line, now, followed);
  followed.reached = mission_.watch(items(), now, controller.estimate(), flies);
  if (const auto goal = line.take_goal()) {
    followed.goal = goals_.take(*goal, now, flies);
    if (followed.goal == GoalAnswer::kFlies || followed.goal == GoalAnswer::kSame) {  // to be there, and stay
      mission_.pause();
    }
  }
  followed.done = followed.order && obey(followed.order->message, now, flies);
  return followed;
}

template <typename T>
void Errands<T>::hear_requests(OverheardLine& line, core::TimePoint now, Followed& followed) {
  const std::uint32_t edition = transfer_.edition();
  for (const Request& request : line.requests()) {
    transfer_.hear(request, mission_.state() == MissionState::kActive, now, followed.replies);
  }
  line.forget_requests();
  transfer_.tick(now, followed.replies);
  followed.new_items = transfer_.edition() != edition;
  if (followed.new_items) {
    mission_.forget(items());
  }
}

template <typename T>
bool Errands<T>::obey(const mavlink::CommandLong& order, core::TimePoint now, bool flies) {
  if (asks_to_hold(order)) {
    mission_.pause();
    return goals_.hold(now, flies);
  }
  if (asks_to_go_on(order)) {
    return mission_.state() == MissionState::kActive || mission_.go_on(items(), now, flies);
  }
  if (order.command != kMissionStart) {
    return false;
  }
  const auto number = [](float value) { return static_cast<std::uint16_t>(value > 0.F && value < 1e4F ? value : 0.F); };
  const std::uint16_t first = number(order.param1), last = number(order.param2);
  return mission_.is_flown_as(items(), first, last) || mission_.start(items(), first, last, now, flies);
}

/// For a flight without goals and missions: passes an order on, refuses a goal, and keeps the list of items empty.
Followed decline(OverheardLine& line);

/// The limits of the ways to goals, as a log has them: "speed acceleration yaw_rate".
std::string goals_note(const ref::SpeedLimits& limits);
/// @returns nothing: the note is of another version.
std::optional<ref::SpeedLimits> limits_of_note(const std::string& note);

}  // namespace m100::companion
