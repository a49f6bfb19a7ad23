// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "firmware/app/flight_controller.h"
#include "firmware/companion/room/goals.h"
#include "firmware/companion/room/overheard_line.h"

namespace m100::companion {

// Commands of MAVLink's common message set that mean something here.
inline constexpr std::uint16_t kGuidedEnable = 92;    ///< MAV_CMD_NAV_GUIDED_ENABLE: param1 1 engage, 0 release
inline constexpr std::uint16_t kPauseContinue = 193;  ///< MAV_CMD_DO_PAUSE_CONTINUE: param1 0 hold
inline constexpr std::uint16_t kLand = 21;            ///< MAV_CMD_NAV_LAND: not there
inline constexpr std::uint16_t kTakeOff = 22;         ///< MAV_CMD_NAV_TAKEOFF: not there

/// What was asked for in a tick, and what became of it.
struct Followed {
  std::optional<GoalAnswer> goal;
  std::optional<OverheardLine::Order> order;
  bool held = false;  ///< the order was to hold, and it holds
};

constexpr bool asks_to_hold(const mavlink::CommandLong& order) {
  return order.command == kPauseContinue && order.param1 < 0.5F;
}

/// After each tick: what came over the pose port in it changes the trajectory from the next on. The same in flight and
/// in a replay; engaging and releasing are the caller's, because they stand in the log as orders.
template <typename T, typename S>
Followed follow(Goals<T>& goals, OverheardLine& line, const app::FlightController<T, S>& controller,
                core::TimePoint now) {
  const safety::Rung rung = controller.supervisor().rung();
  const bool flies =
      controller.link().authority().in_control && (rung == safety::Rung::kNominal || rung == safety::Rung::kCoast);
  goals.watch(now, controller.started(), controller.estimate());
  Followed followed{.goal = {}, .order = line.take_order()};
  if (const auto goal = line.take_goal()) {
    followed.goal = goals.take(*goal, now, flies);
  }
  if (followed.order && asks_to_hold(followed.order->message)) {
    followed.held = goals.hold(now, flies);
  }
  return followed;
}

/// The limits of the ways to goals, as a log has them: "speed acceleration yaw_rate".
std::string goals_note(const ref::SpeedLimits& limits);
/// @returns nothing: the note is of another version.
std::optional<ref::SpeedLimits> limits_of_note(const std::string& note);

}  // namespace m100::companion
