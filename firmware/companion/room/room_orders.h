// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/companion/fly/pilotage.h"
#include "firmware/companion/room/follow.h"
#include "firmware/companion/room/speaker.h"

namespace m100::companion {

/// Who gives orders from the room: goals change the course, an order to engage or release is the operator's word, and
/// each order is answered. What is not there is refused by its name. No heap.
class RoomOrders {
 public:
  /// @param limits nothing: the flight takes no goals (an excitation flies). @param speaker null: nobody is answered.
  RoomOrders(const std::optional<ref::SpeedLimits>& limits, ref::Trajectory<double>& trajectory,
             const core::Fence& fence, OverheardLine& line, Speaker* speaker, Listener& listener)
      : line_(line), speaker_(speaker), listener_(listener) {
    if (limits) {
      goals_.emplace(trajectory, fence, *limits);
    }
  }

  /// After each tick of the controller. @returns true: the room gave the operator's word.
  /// @param waits the operator's word would ask for control now; else it would give it back.
  bool tick(core::TimePoint now, const app::FlightController<double>& controller, bool waits);

 private:
  bool obey(core::TimePoint now, const OverheardLine::Order& order, bool held, bool waits);
  void tell_goal(core::TimePoint now, GoalAnswer answer);
  void answer(const OverheardLine::Order& order, std::uint8_t result);

  std::optional<Goals<double>> goals_;
  OverheardLine& line_;
  Speaker* speaker_;
  Listener& listener_;
  std::optional<GoalAnswer> told_;
};

}  // namespace m100::companion
