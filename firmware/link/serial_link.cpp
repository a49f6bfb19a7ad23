// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/link/serial_link.h"

#include <cstdint>

#include "firmware/core/assert.h"
#include "firmware/link/ack_condition.h"
#include "protocol/dji/catalogue.h"
#include "protocol/dji/pushes.h"

namespace m100::link {
namespace {

using safety::AuthorityCondition;
using safety::when;

/// Two calls of receive() that are further apart mean that our own program stalled: control goes back.
constexpr core::Duration kOwnStall = std::chrono::milliseconds(500);
/// In control the version query is sent this long after the autopilot's last answer. Telemetry shows us in control
/// whether our bytes arrive or not; only an answer proves that they arrive. With the retries it takes at most a second
/// until the operator learns that they do not.
constexpr core::Duration kEchoSpacing = std::chrono::milliseconds(200);
constexpr core::Duration kFreshFor = std::chrono::milliseconds(100);  ///< a telemetry package that is older is stale

/// Messages that only an onboard computer sends.
bool is_our_question(protocol::MessageId id) {
  return id == protocol::ids::kVersionQuery || id == protocol::ids::kActivation || id == protocol::ids::kControlRequest;
}

core::Duration period_or_assert(const ChannelConfig& config) {
  const core::Expected<core::Duration> period = command_period(config);
  M100_ASSERT(period.has_value());
  return *period;
}

}  // namespace

SerialLink::SerialLink(hal::Uart& uart, const LinkConfig& config, ByteTap* tap)
    : config_(config),
      receiver_(uart, config.baud, tap),
      writer_(uart, config, tap),
      limiter_(period_or_assert(config.channel)),
      meter_(config.baud) {}

const protocol::Telemetry& SerialLink::receive(core::TimePoint now) {
  telemetry_.begin();
  receiver_.receive(
      last_step_, now, meter_, [this] { reset_autopilot(); },
      [this](const protocol::FrameView& frame, core::TimePoint arrived) { handle(frame, arrived); });
  if (!receiver_.is_behind()) {
    writer_.poll(now, [this](protocol::MessageId command) {
      edges_ |= when(awaits_ack_of(state_.stage, command), AuthorityCondition::kNoAnswer);
    });
    step_authority(now);
    check_uplink(now);
    flush(now);
  }
  meter_.tick(now);
  authority_.telemetry_fresh = meter_.health().packages > 0 && meter_.health().telemetry_age <= kFreshFor;
  meter_.counters().parser = receiver_.stats();
  meter_.counters().sessions = writer_.stats();
  return telemetry_.telemetry();
}

void SerialLink::reset_autopilot() {
  edges_ |= AuthorityCondition::kPortBack;
  answers_.reset();
  ever_received_ = false;
  telemetry_.reset();
  mode_switch_.reset();
  version_ = {};
}

void SerialLink::handle(const protocol::FrameView& frame, core::TimePoint now) {
  const core::Expected<protocol::Message> message = protocol::open(frame, config_.cipher, scratch_);
  bool says_something_new = true;
  if (!message) {
    ++meter_.counters().undecipherable;
  } else if (message->header.is_ack) {
    handle_answer(*message, now);
  } else if (message->has_id && message->id == protocol::ids::kTelemetry) {
    says_something_new = handle_telemetry(*message, now);
  } else if (message->has_id && is_our_question(message->id)) {
    ++meter_.counters().echoes;  // an autopilot never sends it
    says_something_new = false;
  } else {
    handle_push(*message);
  }
  last_frame_ = says_something_new ? now : last_frame_;
  ever_received_ = ever_received_ || says_something_new;
}

bool SerialLink::handle_telemetry(const protocol::Message& message, core::TimePoint now) {
  const TelemetryReceiver::Reception reception =
      telemetry_.take(message.value, receiver_.follows_damage(), last_step_, now, meter_);
  edges_ |= when(reception.restarted, AuthorityCondition::kRestarted);
  mode_switch_.update(telemetry_.telemetry(), reception.items, now);
  return !reception.is_old;
}

void SerialLink::handle_answer(const protocol::Message& message, core::TimePoint now) {
  const core::Expected<protocol::Answer> answer = writer_.accept(message, now);
  if (answer) {
    last_echo_ = now;
    if (safety::may_command(state_.stage) && answer->command == protocol::ids::kVersionQuery) {
      return;  // in control the version query only tests that our bytes arrive
    }
    const AuthorityCondition sign = ack_condition(*answer);
    edges_ |= awaits_ack_of(state_.stage, answer->command) ? sign : AuthorityCondition::kNone;
  }
}

safety::AuthorityCondition SerialLink::ack_condition(const protocol::Answer& answer) {
  if (answer.command == protocol::ids::kVersionQuery) {
    const core::Expected<protocol::VersionAnswer> version = protocol::decode_version_answer(answer.value);
    if (!version) {
      ++meter_.counters().bad_packages;
      return AuthorityCondition::kNoAnswer;
    }
    version_ = *version;
    const protocol::TelemetryLayout layout = protocol::telemetry_layout(*version);
    telemetry_.set_layout(layout);
    if (!protocol::is_decoded(layout)) {
      authority_.answer = {.code = version->code,
                           .name = protocol::name(layout),
                           .verdict = protocol::AckVerdict::kRefused,
                           .remedy = protocol::remedy(layout)};
      return AuthorityCondition::kRefused;
    }
    return AuthorityCondition::kDone;  // activated or not, both are valid
  }
  const core::Expected<std::uint16_t> code = protocol::decode_ack(answer.value);
  if (!code) {
    ++meter_.counters().bad_packages;
    return AuthorityCondition::kNoAnswer;
  }
  const protocol::AckMeaning meaning = protocol::ack_meaning(answer.command, *code);
  const bool to_a_release =
      answer.command == protocol::ids::kControlRequest && !awaits_ack_of(state_.stage, answer.command);
  authority_.answer = to_a_release ? authority_.answer : meaning;  // telemetry shows the result of a release
  return condition_of(meaning, answer.command);
}

void SerialLink::handle_push(const protocol::Message& message) {
  const protocol::AnswerSessions::Reception reception = answers_.accept(message.header);
  if (reception.verdict == protocol::AnswerSessions::Verdict::kRepeat) {
    writer_.write_answer(reception.bytes);
    return;
  }
  if (reception.verdict == protocol::AnswerSessions::Verdict::kIgnore || !message.has_id) {
    return;
  }
  const core::Expected<protocol::Push> push = protocol::decode_push(message.id, message.value);
  if (!push) {
    ++meter_.counters().bad_packages;
    return;
  }
  if (std::holds_alternative<protocol::ControlLost>(*push)) {
    edges_ |= AuthorityCondition::kControlLostPush;
    if (message.header.session >= protocol::kFirstReliableSession) {
      const core::Expected<protocol::Outgoing> answer =
          answers_.answer(message.header, protocol::encode_ack(protocol::kAckSuccess), config_.cipher);
      if (answer) {
        writer_.write_answer(answer->bytes);
      }
    }
  }
}

void SerialLink::check_uplink(core::TimePoint now) {
  const bool is_asked = writer_.is_open(protocol::ids::kVersionQuery);
  if (authority_.in_control && !is_asked && now - last_echo_ >= kEchoSpacing) {
    (void)writer_.request_echo(now);  // a query that cannot leave gets no answer either
  }
}

safety::AuthorityCondition SerialLink::level_conditions(core::TimePoint now) const {
  using Item = protocol::TelemetryItem;
  const protocol::Telemetry& telemetry = telemetry_.telemetry();
  const protocol::Telemetry::Control& control = telemetry.control;
  const bool uses_virtual_rc = config_.uses_virtual_rc();
  return when(ever_received_ && now - last_frame_ <= kLinkTimeout, AuthorityCondition::kLinkAlive) |
         when(telemetry_.recent(Item::kRc, now, kLinkTimeout) && telemetry_.recent(Item::kControl, now, kLinkTimeout),
              AuthorityCondition::kItemsFresh) |
         when(mode_switch_.is_f(telemetry, uses_virtual_rc), AuthorityCondition::kModeF) |
         when(telemetry.rc.gear == 0, AuthorityCondition::kRcOff) |
         when(control.device() == protocol::ControlDevice::kOnboardComputer, AuthorityCondition::kDeviceOurs) |
         when(control.virtual_rc_on(), AuthorityCondition::kVirtualRcOn) |
         when(uses_virtual_rc, AuthorityCondition::kNeedsVirtualRc);
}

void SerialLink::step_authority(core::TimePoint now) {
  const AuthorityCondition levels = level_conditions(now);
  edges_ |= when(now - last_step_ > kOwnStall, AuthorityCondition::kOwnStall);
  const safety::AuthorityStep made = safety::step(state_, levels | edges_, now - last_step_);
  edges_ = AuthorityCondition::kNone;
  last_step_ = now;
  state_ = made.state;
  if (made.moved) {
    writer_.cancel_requests();
  }
  if (!safety::may_command(state_.stage)) {
    mode_switch_.end_commands();
    meter_.counters().commands_dropped += writer_.has_command() ? 1U : 0U;
    writer_.drop_command();
  }
  perform(made.action, now);
  authority_.stage = state_.stage;
  authority_.reason = state_.reason;
  authority_.in_control = safety::may_command(state_.stage);
  authority_.control_requested = state_.control_requested;
  authority_.release_pending = state_.release_pending;
  authority_.port_gone = receiver_.is_port_gone();
  authority_.mode_f = safety::any(levels, AuthorityCondition::kModeF);
  authority_.link_alive = safety::any(levels, AuthorityCondition::kLinkAlive);
}

void SerialLink::perform(safety::AuthorityAction action, core::TimePoint now) {
  const core::Status sent =
      writer_.perform(action, version_, telemetry_.layout(), telemetry_.telemetry().control.virtual_rc_on(), now);
  edges_ |= when(sent != core::Status::kOk, AuthorityCondition::kNoAnswer);
}

core::Status SerialLink::send(const ChannelCommand& command, core::TimePoint now) {
  if (std::holds_alternative<vrc::Sticks>(command) != config_.uses_virtual_rc()) {
    return core::Status::kInvalidArgument;
  }
  if (!authority_.in_control) {
    ++meter_.counters().commands_refused;
    return core::Status::kRefused;
  }
  if (receiver_.is_behind() || !limiter_.due(now)) {
    return core::Status::kNotReady;
  }
  const bool replaces = writer_.has_command();
  const core::Status made = writer_.write(command);
  if (made != core::Status::kOk) {
    ++meter_.counters().commands_refused;
    return made;
  }
  meter_.counters().commands_dropped += replaces ? 1U : 0U;
  ++meter_.counters().commands_sent;
  limiter_.sent(now);
  mode_switch_.sent(now);
  flush(now);
  return core::Status::kOk;
}

void SerialLink::flush(core::TimePoint now) {
  if (writer_.flush(now, meter_)) {
    limiter_.left(now);
  }
}

void SerialLink::request_control(core::TimePoint) { edges_ |= AuthorityCondition::kControlRequested; }

void SerialLink::release(core::TimePoint) { edges_ |= AuthorityCondition::kReleaseRequested; }

core::Status SerialLink::request(const protocol::MotorRequest& request, core::TimePoint now) {
  return authority_.in_control ? writer_.request(request, now) : core::Status::kRefused;
}

core::Status SerialLink::request(const protocol::TaskRequest& request, core::TimePoint now) {
  const bool possible = authority_.in_control && !task_is_open();
  authority_.answer = possible ? protocol::AckMeaning{} : authority_.answer;
  return possible ? writer_.request(request, now) : core::Status::kRefused;
}

}  // namespace m100::link
