// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "firmware/app/flight_controller.h"
#include "firmware/companion/ground_station/goal_planner.h"
#include "firmware/companion/ground_station/ground_station_tap.h"
#include "firmware/companion/ground_station/mission.h"
#include "firmware/companion/ground_station/mission_transfer.h"

namespace m100::companion {

// Commands of MAVLink's common message set that are obeyed here, in addition to those of GroundStationTap.
inline constexpr std::uint16_t kMissionStart = 300;  ///< MAV_CMD_MISSION_START: param1 first item, param2 last
inline constexpr std::uint16_t kLand = 21;           ///< MAV_CMD_NAV_LAND: the autopilot lands, where it is
inline constexpr std::uint16_t kTakeOff = 22;        ///< MAV_CMD_NAV_TAKEOFF: the autopilot takes off

/// The requests of one tick and their outcome.
struct GuidedModeUpdate {
  std::optional<GoalResult> goal;
  std::optional<GroundStationTap::Order> order;
  bool done = false;                     ///< the order for goals or mission was carried out, now or before
  std::optional<std::uint16_t> reached;  ///< item of the mission that was reached in this tick
  bool new_items = false;                ///< a list of items is complete, or was cleared
  Replies replies;                       ///< of the mission protocol
};

constexpr bool is_hold_command(const mavlink::CommandLong& order) {
  return order.command == kPauseContinue && order.param1 < 0.5F;
}
constexpr bool is_resume_command(const mavlink::CommandLong& order) {
  return order.command == kPauseContinue && order.param1 >= 0.5F;
}

/// The goals that the ground station sends: one at a time, or several as a mission.
template <typename T>
class GuidedMode {
 public:
  GuidedMode(ref::Trajectory<T>& trajectory, const core::Fence& fence, const ref::SpeedLimits& limits)
      : goals_(trajectory, fence, limits), mission_(goals_) {}
  GuidedMode(const GuidedMode&) = delete;
  GuidedMode& operator=(const GuidedMode&) = delete;

  /// Call it after each tick: messages that came over the pose port change the trajectory from the next tick. It
  /// carries out orders to hold, to go on and to start the mission; all other orders are left to the caller.
  template <typename S>
  GuidedModeUpdate update(GroundStationTap& line, const app::FlightController<T, S>& controller, core::TimePoint now);

  const GoalPlanner<T>& goals() const { return goals_; }
  const Mission<T>& mission() const { return mission_; }
  std::span<const mavlink::MissionItemInt> items() const { return transfer_.items(); }

 private:
  void receive_requests(GroundStationTap& line, core::TimePoint now, GuidedModeUpdate& outcome);
  /// @returns whether the order was carried out.
  bool execute(const mavlink::CommandLong& order, core::TimePoint now, bool flies);

  GoalPlanner<T> goals_;
  MissionTransfer transfer_;
  Mission<T> mission_;
};

template <typename T>
template <typename S>
GuidedModeUpdate GuidedMode<T>::update(GroundStationTap& line, const app::FlightController<T, S>& controller,
                                       core::TimePoint now) {
  const safety::FailsafeState failsafe_state = controller.supervisor().failsafe_state();
  const bool flies = controller.link().authority().in_control && (failsafe_state == safety::FailsafeState::kNominal ||
                                                                  failsafe_state == safety::FailsafeState::kCoast);
  goals_.update(now, safety::passes_law(failsafe_state), controller.started(), controller.estimate());
  GuidedModeUpdate outcome;
  outcome.order = line.take_order();
  receive_requests(line, now, outcome);
  outcome.reached = mission_.update(items(), now, controller.estimate(), flies);
  if (const auto goal = line.take_goal()) {
    outcome.goal = goals_.take(*goal, now, flies);
    if (outcome.goal == GoalResult::kAccepted || outcome.goal == GoalResult::kUnchanged) {  // a goal pauses the mission
      mission_.pause();
    }
  }
  outcome.done = outcome.order && execute(outcome.order->message, now, flies);
  return outcome;
}

template <typename T>
void GuidedMode<T>::receive_requests(GroundStationTap& line, core::TimePoint now, GuidedModeUpdate& outcome) {
  const std::uint32_t edition = transfer_.edition();
  for (const Request& request : line.requests()) {
    transfer_.receive(request, mission_.state() == MissionState::kActive, now, outcome.replies);
  }
  line.clear_requests();
  transfer_.tick(now, outcome.replies);
  outcome.new_items = transfer_.edition() != edition;
  if (outcome.new_items) {
    mission_.reset(items());
  }
}

template <typename T>
bool GuidedMode<T>::execute(const mavlink::CommandLong& order, core::TimePoint now, bool flies) {
  if (is_hold_command(order)) {
    mission_.pause();
    return goals_.hold(now, flies);
  }
  if (is_resume_command(order)) {
    return mission_.state() == MissionState::kActive || mission_.resume(items(), now, flies);
  }
  if (order.command != kMissionStart) {
    return false;
  }
  const auto number = [](float value) { return static_cast<std::uint16_t>(value > 0.F && value < 1e4F ? value : 0.F); };
  const std::uint16_t first = number(order.param1), last = number(order.param2);
  return mission_.is_active_as(items(), first, last) || mission_.start(items(), first, last, now, flies);
}

/// For a flight without goals, or on the way back to the start: passes an order on, refuses goals and missions.
GuidedModeUpdate reject_requests(GroundStationTap& line);

/// The limits of the ways to goals as a note in the log: "speed acceleration yaw_rate", SI.
std::string goals_note(const ref::SpeedLimits& limits);
/// @returns nullopt: the note is of another version.
std::optional<ref::SpeedLimits> limits_of_note(const std::string& note);

}  // namespace m100::companion
