// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/room/room_orders.h"

#include <cmath>

namespace m100::companion {
namespace {

// MAV_RESULT
constexpr std::uint8_t kAccepted = 0;
constexpr std::uint8_t kTemporarilyRejected = 1;
constexpr std::uint8_t kDenied = 2;
constexpr std::uint8_t kUnsupported = 3;

std::string_view name(MissionState state) {
  switch (state) {
    case MissionState::kNone:
      return "mission: none";
    case MissionState::kNotStarted:
      return "mission: not started";
    case MissionState::kActive:
      return "mission: active";
    case MissionState::kPaused:
      return "mission: paused";
    case MissionState::kComplete:
      return "mission: complete";
  }
  return "";
}

/// The name in "order from the room: NAME", and the text of a refusal.
struct Spoken {
  std::string_view name;
  std::string_view refusal;
};

Spoken spoken(const mavlink::CommandLong& order) {
  if (asks_to_hold(order)) {
    return {"hold", ", refused: it does not fly by goals now"};
  }
  if (asks_to_go_on(order)) {
    return {"go on with the mission", ", refused: none is paused, or it does not fly by goals now"};
  }
  return {"start the mission", ", refused: there is no such item, or it does not fly by goals now"};
}

bool is_errand(const mavlink::CommandLong& order) {
  return order.command == kPauseContinue || order.command == kMissionStart;
}

/// The answer to an order and the commands that follow from it.
struct Judged {
  std::uint8_t result = kAccepted;
  std::string_view why;  ///< follows its name
  Said said;
};

// An order that is repeated because its answer was lost must not undo the first.
constexpr std::string_view kSoAlready = ", already done";

Judged judge_word(bool engages, const Situation& situation) {
  if (engages && situation.on_ground) {
    return {.result = kTemporarilyRejected, .why = ", refused: it stands on the ground; order a take-off", .said = {}};
  }
  if (engages && situation.hands_back) {
    return {.result = kTemporarilyRejected, .why = ", refused: control is being given back", .said = {}};
  }
  const bool word = engages == situation.waits;
  return {.result = kAccepted, .why = word ? "" : kSoAlready, .said = {.word = word}};
}

/// The autopilot's tasks take neither a place nor a height: an order that names one is refused.
bool is_here(float value) { return std::isnan(value) || value == 0.F; }

Judged judge_landing(const mavlink::CommandLong& order, const Situation& situation) {
  if (!is_here(order.param5) || !is_here(order.param6) || !is_here(order.param7)) {
    return {.result = kDenied, .why = ", refused: it lands where it is; param5 to param7 must be 0", .said = {}};
  }
  if (situation.lands) {
    return {.result = kAccepted, .why = kSoAlready, .said = {}};
  }
  return situation.may_land
             ? Judged{.result = kAccepted, .why = "", .said = {.land = true}}
             : Judged{.result = kTemporarilyRejected, .why = ", refused: it does not fly now", .said = {}};
}

Judged judge_take_off(const mavlink::CommandLong& order, const Situation& situation) {
  if (!is_here(order.param5) || !is_here(order.param6) || !is_here(order.param7)) {
    return {
        .result = kDenied, .why = ", refused: it climbs 1.2 m where it stands; param5 to param7 must be 0", .said = {}};
  }
  if (situation.takes_off) {
    return {.result = kAccepted, .why = kSoAlready, .said = {}};
  }
  return situation.on_ground ? Judged{.result = kAccepted, .why = "", .said = {.word = true}}
                             : Judged{.result = kTemporarilyRejected,
                                      .why =
                                          ", refused: it does not stand on the ground, or m100 was started without "
                                          "--take-off",
                                      .said = {}};
}

}  // namespace

Situation situation_of(const Pilotage& pilotage, core::TimePoint now) {
  return {.waits = pilotage.waits(),
          .hands_back = pilotage.hands_back(),
          .on_ground = pilotage.would_take_off(now),
          .may_land = pilotage.may_land(),
          .takes_off = pilotage.in_task(protocol::Task::kTakeOff),
          .lands = pilotage.in_task(protocol::Task::kLand),
          .goes_home = pilotage.goes_home()};
}

void RoomOrders::hear_parameters(core::TimePoint now) {
  Replies replies;
  for (const Request& request : line_.requests()) {
    parameters_.hear(request, replies);
    const auto* const wish = std::get_if<mavlink::ParamSet>(&request.message);
    if (wish != nullptr && (parameters_not_set_++ == 0 || now - wish_told_at_ >= kWishLines)) {
      wish_told_at_ = now;
      TextLine line;
      listener_.hear(now, line.add("parameter ").add(name_of(*wish)).add(": not set, parameters are read only").text());
    }
  }
  parameters_.tick(replies);
  reply(replies);
}

Said RoomOrders::tick(core::TimePoint now, const app::FlightController<double>& controller,
                      const Situation& situation) {
  hear_parameters(now);
  const Followed followed =
      errands_ && !situation.goes_home ? errands_->follow(line_, controller, now) : decline(line_);
  if (followed.goal) {
    tell_goal(now, situation.goes_home ? GoalAnswer::kGoesHome : *followed.goal);
  }
  reply(followed.replies);
  if (errands_) {
    tell_mission(now, followed);
  }
  return followed.order ? obey(now, *followed.order, followed.done, situation) : Said{};
}

void RoomOrders::reply(const Replies& replies) {
  for (const Reply& one : replies.all()) {
    if (speaker_ != nullptr) {
      speaker_->tell(one);
    }
  }
}

void RoomOrders::tell_goal(core::TimePoint now, GoalAnswer answer) {
  const bool is_new = answer == GoalAnswer::kFlies ? told_ != answer || now - goal_told_at_ >= kGoalLines
                                                   : answer != GoalAnswer::kSame && answer != told_;
  told_ = answer == GoalAnswer::kSame ? told_ : answer;
  if (!is_new) {
    return;  // a repeated goal gives one line, a stream of goals one per second
  }
  goal_told_at_ = now;
  TextLine line;
  line.add("goal from the room");
  if (answer == GoalAnswer::kFlies) {
    const auto& place = errands_->goals().goal()->position_w_m;
    line.add(" (").add(place.x(), 2).add(", ").add(place.y(), 2).add(", ").add(place.z(), 2).add(") m");
  }
  listener_.hear(now, line.add(": ").add(companion::name(answer)).text());
}

void RoomOrders::tell_mission(core::TimePoint now, const Followed& followed) {
  const Mission<double>& mission = errands_->mission();
  if (followed.new_items) {
    const auto count = static_cast<double>(errands_->items().size());
    listener_.hear(now, TextLine{}.add("mission from the room: ").add(count, 0).add(" items").text());
  }
  if (followed.reached) {
    const auto item = static_cast<double>(*followed.reached);
    listener_.hear(now, TextLine{}.add("mission: item ").add(item, 0).add(" is reached").text());
  }
  if (told_mission_.value_or(MissionState::kNone) != mission.state() && mission.state() != MissionState::kNotStarted) {
    listener_.hear(now, name(mission.state()));
  }
  const bool is_due = mission.state() != MissionState::kNone && now - mission_told_at_ >= kMissionLines;
  const bool changed = told_mission_ && *told_mission_ != mission.state();
  told_mission_ = mission.state();
  if (speaker_ == nullptr) {
    return;
  }
  if (followed.reached) {
    speaker_->tell(mavlink::MissionItemReached{.seq = *followed.reached});
  }
  if (is_due || changed || followed.reached) {
    mission_told_at_ = now;
    speaker_->tell(mavlink::MissionCurrent{.seq = mission.current(),
                                           .total = static_cast<std::uint16_t>(errands_->items().size()),
                                           .mission_state = static_cast<std::uint8_t>(mission.state())});
  }
}

Said RoomOrders::obey(core::TimePoint now, const OverheardLine::Order& order, bool done, const Situation& situation) {
  TextLine line;
  line.add("order from the room: ");
  Judged judged{.result = kUnsupported, .why = ", refused: this program does not support it", .said = {}};
  if (order.message.command == kGuidedEnable) {
    judged = judge_word(order.message.param1 >= 0.5F, situation);
    line.add(order.message.param1 >= 0.5F ? "engage" : "release");
  } else if (order.message.command == kLand) {
    judged = judge_landing(order.message, situation);
    line.add("land");
  } else if (order.message.command == kTakeOff) {
    judged = judge_take_off(order.message, situation);
    line.add("take off");
  } else if (is_errand(order.message)) {
    const Spoken words = spoken(order.message);
    judged = {.result = done ? kAccepted : kTemporarilyRejected, .why = done ? "" : words.refusal, .said = {}};
    line.add(words.name);
  } else {
    line.add("command ").add(static_cast<double>(order.message.command), 0);
  }
  listener_.hear(now, line.add(judged.why).text());
  answer(order, judged.result);
  return judged.said;
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
