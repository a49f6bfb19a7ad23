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

/// The answer to an order and the commands that follow from it.
struct CommandDecision {
  std::uint8_t result = kAccepted;
  std::string_view why;  ///< follows the order's name in the report
  OperatorInput input{};
};

// An order that is repeated because its answer was lost must not undo the first.
constexpr std::string_view kAlreadyDone = ", already done";

CommandDecision decide_engage(bool engages, const SequencerStatus& status) {
  if (engages && status.on_ground) {
    return {.result = kTemporarilyRejected, .why = ", refused: it stands on the ground; order a take-off"};
  }
  if (engages && status.is_releasing) {
    return {.result = kTemporarilyRejected, .why = ", refused: control is being given back"};
  }
  const bool toggle_control = engages == status.waits;
  return {.result = kAccepted, .why = toggle_control ? "" : kAlreadyDone, .input = {.toggle_control = toggle_control}};
}

/// The autopilot's tasks take neither a place nor a height: an order that names one is refused.
bool is_here(float value) { return std::isnan(value) || value == 0.F; }

CommandDecision decide_landing(const mavlink::CommandLong& order, const SequencerStatus& status) {
  if (!is_here(order.param5) || !is_here(order.param6) || !is_here(order.param7)) {
    return {.result = kDenied, .why = ", refused: it lands where it is; param5 to param7 must be 0"};
  }
  if (status.lands) {
    return {.result = kAccepted, .why = kAlreadyDone};
  }
  return status.may_land ? CommandDecision{.result = kAccepted, .why = "", .input = {.land = true}}
                         : CommandDecision{.result = kTemporarilyRejected, .why = ", refused: it does not fly now"};
}

CommandDecision decide_take_off(const mavlink::CommandLong& order, const SequencerStatus& status) {
  if (!is_here(order.param5) || !is_here(order.param6) || !is_here(order.param7)) {
    return {.result = kDenied, .why = ", refused: it climbs 1.2 m where it stands; param5 to param7 must be 0"};
  }
  if (status.takes_off) {
    return {.result = kAccepted, .why = kAlreadyDone};
  }
  return status.on_ground
             ? CommandDecision{.result = kAccepted, .why = "", .input = {.toggle_control = true}}
             : CommandDecision{.result = kTemporarilyRejected,
                               .why =
                                   ", refused: it does not stand on the ground, or m100 was started without "
                                   "--take-off"};
}

/// "; the fence cut 2.30 m off x, 0.40 m off z"
void add_cut(TextLine& line, const core::Vector<double, 3>& cut_w_m) {
  constexpr std::array<std::string_view, 3> kAxes{"x", "y", "z"};
  std::string_view before = "; the fence cut ";
  for (std::size_t axis = 0; axis < kAxes.size(); ++axis) {
    if (const double cut_m = cut_w_m[static_cast<Eigen::Index>(axis)]; cut_m > 0.0) {
      line.add(before).add_significant(cut_m).add(" m off ").add(kAxes[axis]);
      before = ", ";
    }
  }
}

}  // namespace

OperatorInput GroundStationCommands::tick(core::TimePoint now, const app::FlightController<double>& controller,
                                          const SequencerStatus& status) {
  for (const Reply& answer : line_.answers()) {
    send(answer);
  }
  line_.clear_answers();
  const GuidedModeUpdate outcome = follower_ && !status.returns_to_start
                                       ? update_guided_mode(*follower_, line_, controller, now)
                                       : reject_goals(line_);
  if (outcome.goal) {
    report_goal(now, status.returns_to_start ? GoalResult::kReturningToStart : *outcome.goal);
  }
  return outcome.order ? execute(now, *outcome.order, outcome.holds, status) : OperatorInput{};
}

void GroundStationCommands::send(const Reply& reply) {
  if (telemetry_stream_ != nullptr) {
    telemetry_stream_->publish(reply);
  }
}

bool GroundStationCommands::is_new(core::TimePoint now, GoalResult answer) const {
  const core::TimePoint last = reported_at_[static_cast<std::size_t>(answer)];
  const bool waits = last != core::TimePoint{} && now - last < kGoalReportInterval;
  if (answer == GoalResult::kAccepted) {
    return answer != reported_ || !waits;
  }
  return answer != reported_ && answer != GoalResult::kUnchanged && answer != GoalResult::kFirst && !waits;
}

void GroundStationCommands::report_goal(core::TimePoint now, GoalResult answer) {
  if (!is_new(now, answer)) {
    return;
  }
  reported_ = answer;
  reported_at_[static_cast<std::size_t>(answer)] = now;
  TextLine line;
  line.add("goal from the ground station");
  if (answer == GoalResult::kAccepted) {
    const auto& place = follower_->goals.goal()->position_w_m;
    line.add(" (").add(place.x(), 2).add(", ").add(place.y(), 2).add(", ").add(place.z(), 2).add(") m");
  }
  line.add(": ").add(companion::name(answer));
  const double exceeding = follower_ && follower_->stream ? follower_->stream->exceeding() : 0.0;
  if (is_stream(answer) && exceeding != 0.0) {
    line.add(" (").add_significant(exceeding).add(answer == GoalResult::kStreamFar ? " m)" : ")");
  } else if (follower_ && answer == GoalResult::kAccepted) {
    add_cut(line, follower_->goals.cut_w_m());
  } else if (follower_ && answer != GoalResult::kReturningToStart && follower_->goals.refused_value() != 0.0) {
    line.add(" (").add_significant(follower_->goals.refused_value()).add(")");
  }
  operator_log_.write(now, line.text());
}

OperatorInput GroundStationCommands::execute(core::TimePoint now, const GroundStationTap::Order& order, bool holds,
                                             const SequencerStatus& status) {
  TextLine line;
  line.add("order from the ground station: ");
  CommandDecision decision{.result = kUnsupported, .why = ", refused: this program does not support it"};
  if (order.message.command == kGuidedEnable) {
    decision = decide_engage(order.message.param1 >= 0.5F, status);
    line.add(order.message.param1 >= 0.5F ? "engage" : "release");
  } else if (order.message.command == kLand) {
    decision = decide_landing(order.message, status);
    line.add("land");
  } else if (order.message.command == kTakeOff) {
    decision = decide_take_off(order.message, status);
    line.add("take off");
  } else if (is_hold_command(order.message)) {
    decision = {.result = holds ? kAccepted : kTemporarilyRejected,
                .why = holds ? "" : ", refused: it does not fly by goals now"};
    line.add("hold");
  } else {
    line.add("command ").add(static_cast<double>(order.message.command), 0);
  }
  if (!line_.is_signed()) {
    decision = {.result = kDenied, .why = ", refused: orders need a signature (--mavlink-key)"};
  }
  operator_log_.write(now, line.add(decision.why).text());
  send(mavlink::CommandAck{.command = order.message.command,
                           .result = decision.result,
                           .target_system = order.from.system,
                           .target_component = order.from.component});
  return decision.input;
}

}  // namespace m100::companion
