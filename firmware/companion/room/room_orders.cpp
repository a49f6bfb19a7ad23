// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/room/room_orders.h"

namespace m100::companion {
namespace {

// MAV_RESULT
constexpr std::uint8_t kAccepted = 0;
constexpr std::uint8_t kTemporarilyRejected = 1;
constexpr std::uint8_t kUnsupported = 3;

}  // namespace

bool RoomOrders::tick(core::TimePoint now, const app::FlightController<double>& controller, bool waits) {
  Followed followed;
  if (goals_) {
    followed = follow(*goals_, line_, controller, now);
  } else {
    followed.order = line_.take_order();
    if (line_.take_goal()) {
      followed.goal = GoalAnswer::kNotFlying;
    }
  }
  if (followed.goal) {
    tell_goal(now, *followed.goal);
  }
  return followed.order && obey(now, *followed.order, followed.held, waits);
}

void RoomOrders::tell_goal(core::TimePoint now, GoalAnswer answer) {
  const bool is_new = answer == GoalAnswer::kFlies || (answer != GoalAnswer::kSame && answer != told_);
  told_ = answer;
  if (!is_new) {
    return;  // who repeats a goal is told once
  }
  TextLine line;
  line.add("goal from the room");
  if (answer == GoalAnswer::kFlies) {
    const auto& place = goals_->goal()->position_w_m;
    line.add(" (").add(place.x(), 2).add(", ").add(place.y(), 2).add(", ").add(place.z(), 2).add(") m");
  }
  listener_.hear(now, line.add(": ").add(name(answer)).text());
}

bool RoomOrders::obey(core::TimePoint now, const OverheardLine::Order& order, bool held, bool waits) {
  const bool is_on = order.message.param1 >= 0.5F;
  TextLine line;
  line.add("order from the room: ");
  std::uint8_t result = kAccepted;
  bool word = false;
  if (order.message.command == kGuidedEnable) {
    word = is_on == waits;  // one that is repeated, because its answer was lost, must not undo the first
    line.add(is_on ? "engage" : "release").add(word ? "" : ", which is so already");
  } else if (asks_to_hold(order.message)) {
    result = held ? kAccepted : kTemporarilyRejected;
    line.add("hold").add(held ? "" : ", refused: it does not fly by goals now");
  } else {
    result = kUnsupported;
    const std::uint16_t command = order.message.command;
    line.add(command == kLand ? "land" : command == kTakeOff ? "take off" : "command ");
    if (command != kLand && command != kTakeOff) {
      line.add(static_cast<double>(command), 0);
    }
    line.add(", refused: this program does not have it");
  }
  listener_.hear(now, line.text());
  answer(order, result);
  return word;
}

void RoomOrders::answer(const OverheardLine::Order& order, std::uint8_t result) {
  if (speaker_ != nullptr) {
    speaker_->tell(mavlink::CommandAck{.command = order.message.command,
                                       .result = result,
                                       .target_system = order.from.system,
                                       .target_component = order.from.component});
  }
}

}  // namespace m100::companion
