// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "firmware/app/flight_controller.h"
#include "firmware/companion/ground_station/goal_planner.h"
#include "firmware/companion/ground_station/ground_station_tap.h"

namespace m100::companion {

// Commands of MAVLink's common message set that are obeyed here, in addition to those of GroundStationTap.
inline constexpr std::uint16_t kLand = 21;     ///< MAV_CMD_NAV_LAND: the autopilot lands, where it is
inline constexpr std::uint16_t kTakeOff = 22;  ///< MAV_CMD_NAV_TAKEOFF: the autopilot takes off

/// The goal and the order of one tick and their outcome.
struct GuidedModeUpdate {
  std::optional<GoalResult> goal;
  std::optional<GroundStationTap::Order> order;
  bool holds = false;  ///< the order was to hold, and the reference comes to rest
};

/// Call it after each tick: a goal that came over the pose port, and an order to hold, change the trajectory from the
/// next tick. All other orders are left to the caller.
template <typename T, typename S>
GuidedModeUpdate update_guided_mode(GoalPlanner<T>& goals, GroundStationTap& line,
                                    const app::FlightController<T, S>& controller, core::TimePoint now) {
  const safety::FailsafeState failsafe_state = controller.supervisor().failsafe_state();
  const bool flies = controller.link().authority().in_control && (failsafe_state == safety::FailsafeState::kNominal ||
                                                                  failsafe_state == safety::FailsafeState::kCoast);
  goals.update(now, safety::passes_law(failsafe_state), controller.started(), controller.estimate());
  GuidedModeUpdate outcome;
  outcome.order = line.take_order();
  outcome.goal = line.take_stranger() ? std::optional(GoalResult::kUnsigned) : std::nullopt;
  if (const auto goal = line.take_goal()) {
    outcome.goal = goals.take(*goal, now, flies, controller.source_frame());
  }
  outcome.holds =
      outcome.order && line.is_signed() && is_hold_command(outcome.order->message) && goals.hold(now, flies);
  return outcome;
}

/// For a flight without goals, or on the way back to the start: passes an order on, refuses a goal.
GuidedModeUpdate reject_goals(GroundStationTap& line);

/// How a flight takes goals.
struct GoalSettings {
  ref::SpeedLimits limits;
  std::optional<mavlink::Address> only{};  ///< whose goals count, as GroundStationTap has it
};
/// The limits of the ways to goals as a note in the log: "speed acceleration yaw_rate", SI; for goals without a
/// signature, system and component of their sender follow.
std::string goals_note(const GoalSettings& settings);
/// @returns nullopt: the note is of another version.
std::optional<GoalSettings> goals_of_note(const std::string& note);

}  // namespace m100::companion
