// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "firmware/app/flight_controller.h"
#include "firmware/companion/ground_station/goal_planner.h"
#include "firmware/companion/ground_station/ground_station_tap.h"
#include "firmware/companion/ground_station/set_point_stream.h"

namespace m100::companion {

// Commands of MAVLink's common message set that are obeyed here, in addition to those of GroundStationTap.
inline constexpr std::uint16_t kLand = 21;     ///< MAV_CMD_NAV_LAND: the autopilot lands, where it is
inline constexpr std::uint16_t kTakeOff = 22;  ///< MAV_CMD_NAV_TAKEOFF: the autopilot takes off

/// How a flight takes goals.
struct GoalSettings {
  ref::SpeedLimits limits;                 ///< of the ways to goals
  std::optional<StreamLimits> stream{};    ///< nullopt: an older version's flight, to which each set point was a goal
  std::optional<mavlink::Address> only{};  ///< whose goals count, as GroundStationTap has it
};

/// What flies goals and streams of set points.
template <typename T>
struct GoalFollower {
  GoalFollower(ref::Trajectory<T>& trajectory, const core::Fence& fence, const GoalSettings& settings)
      : goals(trajectory, fence, settings.limits) {
    if (settings.stream) {
      stream.emplace(trajectory, fence, *settings.stream);
    }
  }
  GoalPlanner<T> goals;
  std::optional<SetPointStream<T>> stream;
};

/// The goal and the order of one tick and their outcome.
struct GuidedModeUpdate {
  std::optional<GoalResult> goal;
  std::optional<GroundStationTap::Order> order;
  bool holds = false;  ///< the order was to hold, and the reference comes to rest
};

/// Call it after each tick: a goal that came over the pose port, and an order to hold, change the trajectory from the
/// next tick. All other orders are left to the caller.
template <typename T, typename S>
GuidedModeUpdate update_guided_mode(GoalFollower<T>& follower, GroundStationTap& line,
                                    const app::FlightController<T, S>& controller, core::TimePoint now) {
  GoalPlanner<T>& goals = follower.goals;
  std::optional<SetPointStream<T>>& stream = follower.stream;
  const safety::FailsafeState failsafe_state = controller.supervisor().failsafe_state();
  const bool flies = controller.link().authority().in_control && (failsafe_state == safety::FailsafeState::kNominal ||
                                                                  failsafe_state == safety::FailsafeState::kCoast);
  goals.update(now, safety::passes_law(failsafe_state), controller.started(), controller.estimate());
  GuidedModeUpdate outcome;
  outcome.order = line.take_order();
  outcome.goal = line.take_stranger() ? std::optional(GoalResult::kUnsigned) : std::nullopt;
  if (const auto ended = stream ? stream->update(now, flies, goals) : std::nullopt) {
    outcome.goal = ended;
  }
  while (const auto goal = line.take_goal()) {
    outcome.goal = stream ? stream->take(goal->message, goal->from, now, flies, controller.source_frame(), goals)
                          : goals.take(goal->message, now, flies, controller.source_frame());
  }
  outcome.holds =
      outcome.order && line.is_signed() && is_hold_command(outcome.order->message) && goals.hold(now, flies);
  if (outcome.holds && stream) {
    stream->hold();
  }
  return outcome;
}

/// For a flight without goals, or on the way back to the start: passes an order on, refuses a goal.
GuidedModeUpdate reject_goals(GroundStationTap& line);

/// The settings as a note in the log, SI: "speed acceleration yaw_rate", then "stream speed acceleration climb
/// yaw_rate", and for goals without a signature "from system component".
std::string goals_note(const GoalSettings& settings);
/// @returns nullopt: the note is of another version.
std::optional<GoalSettings> goals_of_note(const std::string& note);

}  // namespace m100::companion
