// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/ground_station/ground_station_commands.h"

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

/// The name in "order from the ground station: NAME", and the text of a refusal.
struct CommandText {
  std::string_view name;
  std::string_view refusal;
};

CommandText command_text(const mavlink::CommandLong& order) {
  if (is_hold_command(order)) {
    return {"hold", ", refused: it does not fly by goals now"};
  }
  if (is_resume_command(order)) {
    return {"go on with the mission", ", refused: none is paused, or it does not fly by goals now"};
  }
  return {"start the mission", ", refused: there is no such item, or it does not fly by goals now"};
}

bool is_guided_command(const mavlink::CommandLong& order) {
  return order.command == kPauseContinue || order.command == kMissionStart;
}

/// The answer to an order and the commands that follow from it.
struct CommandDecision {
  std::uint8_t result = kAccepted;
  std::string_view why;  ///< follows the order's name in the report
  OperatorInput input;
};

// An order that is repeated because its answer was lost must not undo the first.
constexpr std::string_view kAlreadyDone = ", already done";

CommandDecision decide_engage(bool engages, const SequencerStatus& status) {
  if (engages && status.on_ground) {
    return {.result = kTemporarilyRejected, .why = ", refused: it stands on the ground; order a take-off", .input = {}};
  }
  if (engages && status.is_releasing) {
    return {.result = kTemporarilyRejected, .why = ", refused: control is being given back", .input = {}};
  }
  const bool toggle_control = engages == status.waits;
  return {.result = kAccepted, .why = toggle_control ? "" : kAlreadyDone, .input = {.toggle_control = toggle_control}};
}

/// The autopilot's tasks take neither a place nor a height: an order that names one is refused.
bool is_here(float value) { return std::isnan(value) || value == 0.F; }

CommandDecision decide_landing(const mavlink::CommandLong& order, const SequencerStatus& status) {
  if (!is_here(order.param5) || !is_here(order.param6) || !is_here(order.param7)) {
    return {.result = kDenied, .why = ", refused: it lands where it is; param5 to param7 must be 0", .input = {}};
  }
  if (status.lands) {
    return {.result = kAccepted, .why = kAlreadyDone, .input = {}};
  }
  return status.may_land
             ? CommandDecision{.result = kAccepted, .why = "", .input = {.land = true}}
             : CommandDecision{.result = kTemporarilyRejected, .why = ", refused: it does not fly now", .input = {}};
}

CommandDecision decide_take_off(const mavlink::CommandLong& order, const SequencerStatus& status) {
  if (!is_here(order.param5) || !is_here(order.param6) || !is_here(order.param7)) {
    return {.result = kDenied,
            .why = ", refused: it climbs 1.2 m where it stands; param5 to param7 must be 0",
            .input = {}};
  }
  if (status.takes_off) {
    return {.result = kAccepted, .why = kAlreadyDone, .input = {}};
  }
  return status.on_ground
             ? CommandDecision{.result = kAccepted, .why = "", .input = {.toggle_control = true}}
             : CommandDecision{.result = kTemporarilyRejected,
                               .why =
                                   ", refused: it does not stand on the ground, or m100 was started without "
                                   "--take-off",
                               .input = {}};
}

}  // namespace

SequencerStatus sequencer_status(const FlightSequencer& sequencer, core::TimePoint now) {
  return {.waits = sequencer.waits(),
          .is_releasing = sequencer.is_releasing(),
          .on_ground = sequencer.engage_takes_off(now),
          .may_land = sequencer.may_land(),
          .takes_off = sequencer.in_task(protocol::Task::kTakeOff),
          .lands = sequencer.in_task(protocol::Task::kLand),
          .returns_to_start = sequencer.returns_to_start()};
}

void GroundStationCommands::receive_parameters(core::TimePoint now) {
  Replies replies;
  for (const Request& request : line_.requests()) {
    parameters_.receive(request, replies);
    const auto* const parameter = std::get_if<mavlink::ParamSet>(&request.message);
    if (parameter != nullptr &&
        (parameters_not_set_++ == 0 || now - parameter_reported_at_ >= kParameterReportInterval)) {
      parameter_reported_at_ = now;
      TextLine line;
      operator_log_.write(
          now, line.add("parameter ").add(name_of(*parameter)).add(": not set, parameters are read only").text());
    }
  }
  parameters_.tick(replies);
  reply(replies);
}

OperatorInput GroundStationCommands::tick(core::TimePoint now, const app::FlightController<double>& controller,
                                          const SequencerStatus& status) {
  receive_parameters(now);
  const GuidedModeUpdate outcome =
      guided_mode_ && !status.returns_to_start ? guided_mode_->update(line_, controller, now) : reject_requests(line_);
  if (outcome.goal) {
    report_goal(now, status.returns_to_start ? GoalResult::kReturningToStart : *outcome.goal);
  }
  reply(outcome.replies);
  if (guided_mode_) {
    report_mission(now, outcome);
  }
  return outcome.order ? execute(now, *outcome.order, outcome.done, status) : OperatorInput{};
}

void GroundStationCommands::reply(const Replies& replies) {
  for (const Reply& one : replies.all()) {
    if (telemetry_stream_ != nullptr) {
      telemetry_stream_->publish(one);
    }
  }
}

void GroundStationCommands::report_goal(core::TimePoint now, GoalResult answer) {
  const bool is_new = answer == GoalResult::kAccepted
                          ? reported_ != answer || now - goal_reported_at_ >= kGoalReportInterval
                          : answer != GoalResult::kUnchanged && answer != reported_;
  reported_ = answer == GoalResult::kUnchanged ? reported_ : answer;
  if (!is_new) {
    return;  // a repeated goal gives one line, a stream of goals one per second
  }
  goal_reported_at_ = now;
  TextLine line;
  line.add("goal from the ground station");
  if (answer == GoalResult::kAccepted) {
    const auto& place = guided_mode_->goals().goal()->position_w_m;
    line.add(" (").add(place.x(), 2).add(", ").add(place.y(), 2).add(", ").add(place.z(), 2).add(") m");
  }
  operator_log_.write(now, line.add(": ").add(companion::name(answer)).text());
}

void GroundStationCommands::report_mission(core::TimePoint now, const GuidedModeUpdate& outcome) {
  const Mission<double>& mission = guided_mode_->mission();
  if (outcome.new_items) {
    const auto count = static_cast<double>(guided_mode_->items().size());
    operator_log_.write(now, TextLine{}.add("mission from the ground station: ").add(count, 0).add(" items").text());
  }
  if (outcome.reached) {
    const auto item = static_cast<double>(*outcome.reached);
    operator_log_.write(now, TextLine{}.add("mission: item ").add(item, 0).add(" is reached").text());
  }
  if (reported_mission_.value_or(MissionState::kNone) != mission.state() &&
      mission.state() != MissionState::kNotStarted) {
    operator_log_.write(now, name(mission.state()));
  }
  const bool is_due = mission.state() != MissionState::kNone && now - mission_reported_at_ >= kMissionReportInterval;
  const bool changed = reported_mission_ && *reported_mission_ != mission.state();
  reported_mission_ = mission.state();
  if (telemetry_stream_ == nullptr) {
    return;
  }
  if (outcome.reached) {
    telemetry_stream_->publish(mavlink::MissionItemReached{.seq = *outcome.reached});
  }
  if (is_due || changed || outcome.reached) {
    mission_reported_at_ = now;
    telemetry_stream_->publish(
        mavlink::MissionCurrent{.seq = mission.current(),
                                .total = static_cast<std::uint16_t>(guided_mode_->items().size()),
                                .mission_state = static_cast<std::uint8_t>(mission.state())});
  }
}

OperatorInput GroundStationCommands::execute(core::TimePoint now, const GroundStationTap::Order& order, bool done,
                                             const SequencerStatus& status) {
  TextLine line;
  line.add("order from the ground station: ");
  CommandDecision decision{.result = kUnsupported, .why = ", refused: this program does not support it", .input = {}};
  if (order.message.command == kGuidedEnable) {
    decision = decide_engage(order.message.param1 >= 0.5F, status);
    line.add(order.message.param1 >= 0.5F ? "engage" : "release");
  } else if (order.message.command == kLand) {
    decision = decide_landing(order.message, status);
    line.add("land");
  } else if (order.message.command == kTakeOff) {
    decision = decide_take_off(order.message, status);
    line.add("take off");
  } else if (is_guided_command(order.message)) {
    const CommandText words = command_text(order.message);
    decision = {.result = done ? kAccepted : kTemporarilyRejected, .why = done ? "" : words.refusal, .input = {}};
    line.add(words.name);
  } else {
    line.add("command ").add(static_cast<double>(order.message.command), 0);
  }
  operator_log_.write(now, line.add(decision.why).text());
  answer(order, decision.result);
  return decision.input;
}

void GroundStationCommands::answer(const GroundStationTap::Order& order, std::uint8_t result) {
  if (telemetry_stream_ != nullptr) {
    telemetry_stream_->publish(mavlink::CommandAck{.command = order.message.command,
                                                   .result = result,
                                                   .target_system = order.from.system,
                                                   .target_component = order.from.component});
  }
}

}  // namespace m100::companion
