// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/companion/fly/pilotage.h"
#include "firmware/companion/fly/said.h"
#include "firmware/companion/room/follow.h"
#include "firmware/companion/room/parameters.h"
#include "firmware/companion/room/speaker.h"

namespace m100::companion {

/// How the operator's part of the flight would treat an order now.
struct Situation {
  bool waits = false;       ///< a command would request control; otherwise it would give it back
  bool hands_back = false;  ///< control goes back: a command has no effect
  bool on_ground = false;   ///< a command would take off first
  bool may_land = false;
  bool takes_off = false;  ///< the autopilot takes off
  bool lands = false;
  bool goes_home = false;  ///< the battery is low: the room cannot change the course
};
Situation situation_of(const Pilotage& pilotage, core::TimePoint now);

/// Handles goals, missions and orders from the room: goals and missions change the course, an order to engage or
/// release has the effect of the operator's command, and each order is answered. An unknown order is refused by its
/// number. No heap.
class RoomOrders {
 public:
  /// @param limits nothing: the flight takes no goals (an excitation flies). @param speaker null: nothing is answered,
  /// and so no mission can be transferred.
  RoomOrders(const std::optional<ref::SpeedLimits>& limits, const model::Vehicle& vehicle,
             const app::FlightConfig& config, ref::Trajectory<double>& trajectory, OverheardLine& line,
             Speaker* speaker, Listener& listener)
      : parameters_({vehicle, config, limits.value_or(ref::SpeedLimits{})}),
        line_(line),
        speaker_(speaker),
        listener_(listener) {
    if (limits) {
      errands_.emplace(trajectory, config.fence, *limits);
    }
  }

  /// Call it after each tick of the controller. @returns the commands that the room gave in the operator's place.
  Said tick(core::TimePoint now, const app::FlightController<double>& controller, const Situation& situation);
  /// Goals have led the flight.
  bool leads() const { return errands_ && errands_->goals().goal().has_value(); }
  /// Number of requests to change a parameter; each is answered with the unchanged value.
  std::uint32_t parameters_not_set() const { return parameters_not_set_; }

 private:
  static constexpr core::Duration kGoalLines = std::chrono::seconds(1);     ///< between two lines about goals
  static constexpr core::Duration kMissionLines = std::chrono::seconds(1);  ///< between two MISSION_CURRENT
  static constexpr core::Duration kWishLines = std::chrono::seconds(1);     ///< between two lines about PARAM_SET

  void hear_parameters(core::TimePoint now);
  Said obey(core::TimePoint now, const OverheardLine::Order& order, bool done, const Situation& situation);
  void tell_goal(core::TimePoint now, GoalAnswer answer);
  void tell_mission(core::TimePoint now, const Followed& followed);
  void answer(const OverheardLine::Order& order, std::uint8_t result);
  void reply(const Replies& replies);

  std::optional<Errands<double>> errands_;
  Parameters parameters_;
  OverheardLine& line_;
  Speaker* speaker_;
  Listener& listener_;
  std::optional<GoalAnswer> told_;
  core::TimePoint goal_told_at_{};
  std::optional<MissionState> told_mission_;
  core::TimePoint mission_told_at_{};
  std::uint32_t parameters_not_set_ = 0;
  core::TimePoint wish_told_at_{};
};

}  // namespace m100::companion
