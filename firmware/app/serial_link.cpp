// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/app/serial_link.h"

#include "firmware/app/answer_meaning.h"
#include "firmware/app/telemetry_check.h"
#include "firmware/core/assert.h"
#include "protocol/catalogue.h"
#include "protocol/commands.h"
#include "protocol/pushes.h"

namespace m100::app {
namespace {

using safety::Fact;
using safety::Stage;
using safety::when;

/// Bytes per visit to the UART; several visits per tick.
constexpr std::size_t kChunkBytes = 512;
/// The autopilot counts 400 Hz ticks. A jump of more than this against our own clock means that it restarted.
constexpr core::Duration kClockTick = std::chrono::microseconds(2500);
constexpr core::Duration kClockJump = std::chrono::seconds(1);

core::Duration period_or_assert(const ChannelConfig& config) {
  const core::Expected<core::Duration> period = command_period(config);
  M100_ASSERT(period.has_value());
  return *period;
}

}  // namespace

SerialLink::SerialLink(hal::Uart& uart, const LinkConfig& config, ByteTap* tap)
    : uart_(uart), config_(config), tap_(tap), limiter_(period_or_assert(config.channel)), meter_(config.baud) {}

const protocol::Telemetry& SerialLink::receive(core::TimePoint now) {
  telemetry_.items = 0;
  collect(now);
  poll_sessions(now);
  step_authority(now);
  flush(now);
  meter_.tick(now);
  meter_.counters().parser = parser_.stats();
  meter_.counters().sessions = sessions_.stats();
  return telemetry_;
}

void SerialLink::collect(core::TimePoint now) {
  std::array<std::byte, kChunkBytes> chunk;
  for (std::size_t visit = 0; visit < kBytesPerTick / kChunkBytes; ++visit) {
    const core::Expected<std::size_t> count = uart_.read(chunk);
    if (!count) {
      meter_.counters().outages += port_was_gone_ ? 0U : 1U;
      port_was_gone_ = true;
      return;
    }
    if (port_was_gone_) {
      port_was_gone_ = false;
      edges_ |= when(ever_heard_, Fact::kRestarted);  // whoever answers now may be another
      clock_known_ = false;
    }
    const std::span<const std::byte> bytes = std::span(chunk).first(*count);
    if (bytes.empty()) {
      return;
    }
    meter_.received(bytes.size());
    if (tap_ != nullptr) {
      tap_->received(bytes, now);
    }
    parser_.consume(bytes, [&](const protocol::FrameView& frame) { handle(frame, now); });
  }
}

void SerialLink::handle(const protocol::FrameView& frame, core::TimePoint now) {
  last_frame_ = now;
  ever_heard_ = true;
  const core::Expected<protocol::Message> message = protocol::open(frame, config_.cipher, scratch_);
  if (!message) {
    ++meter_.counters().undecipherable;
  } else if (message->header.is_ack) {
    handle_answer(*message, now);
  } else if (message->has_id && message->id == protocol::ids::kTelemetry) {
    handle_telemetry(*message, now);
  } else {
    handle_push(*message);
  }
}

void SerialLink::handle_telemetry(const protocol::Message& message, core::TimePoint now) {
  const protocol::Telemetry former = telemetry_;
  if (protocol::decode_telemetry(message.value, telemetry_) != core::Status::kOk) {
    ++meter_.counters().bad_packages;
    return;
  }
  meter_.counters().refused_items += keep_finite(telemetry_, former);
  meter_.package(now);
  for (std::size_t item = 0; item < item_times_.size(); ++item) {
    if (((std::uint32_t{telemetry_.items} >> item) & 1U) != 0) {
      item_times_[item] = now;
    }
  }
  if (telemetry_.has(protocol::TelemetryItem::kTime)) {
    watch_clock(now);
  }
  watch_mode_switch(now);
  seen_items_ = static_cast<std::uint16_t>(seen_items_ | telemetry_.items);
  telemetry_.items = static_cast<std::uint16_t>(telemetry_.items | former.items);
}

void SerialLink::watch_mode_switch(core::TimePoint now) {
  const bool ours_would_show = commanded_ && now - first_command_ >= kOwnModeShows;
  rc_item_is_real_ =
      rc_item_is_real_ || (telemetry_.has(protocol::TelemetryItem::kRc) && ours_would_show &&
                           telemetry_.control.virtual_rc_on() && telemetry_.rc.mode == protocol::kRcModeF);
}

void SerialLink::watch_clock(core::TimePoint now) {
  const std::uint32_t ticks = telemetry_.time.ticks;
  if (clock_known_) {
    // Signed, so that the wrap of the counter is a step of one tick.
    const auto stepped = static_cast<std::int32_t>(ticks - clock_ticks_) * kClockTick;
    const core::Duration difference = stepped - (now - clock_time_);
    if (difference > kClockJump || difference < -kClockJump) {
      edges_ |= Fact::kRestarted;
      meter_.restart();
    }
  }
  clock_known_ = true;
  clock_ticks_ = ticks;
  clock_time_ = now;
  meter_.timed_package(now, static_cast<std::int64_t>(ticks) * kClockTick);
}

void SerialLink::handle_answer(const protocol::Message& message, core::TimePoint now) {
  const core::Expected<protocol::Answer> answer = sessions_.accept(message, now);
  if (answer) {
    const Fact fact = fact_of(*answer);
    edges_ |= is_question_of(state_.stage, answer->command) ? fact : Fact::kNone;
  }
}

safety::Fact SerialLink::fact_of(const protocol::Answer& answer) {
  if (answer.command == protocol::ids::kVersionQuery) {
    const core::Expected<protocol::VersionAnswer> version = protocol::decode_version_answer(answer.value);
    const core::Expected<std::uint32_t> number =
        version ? protocol::sdk_version(*version) : core::Expected<std::uint32_t>(version.status());
    if (!number) {
      ++meter_.counters().bad_packages;
      return Fact::kNoAnswer;
    }
    version_ = *version;
    sdk_version_ = *number;
    return Fact::kDone;  // activated or not, both are fine
  }
  const core::Expected<std::uint16_t> code = protocol::decode_ack(answer.value);
  if (!code) {
    ++meter_.counters().bad_packages;
    return Fact::kNoAnswer;
  }
  authority_.answer = protocol::ack_meaning(answer.command, *code);
  return meaning_of(authority_.answer, answer.command, state_.stage);
}

void SerialLink::handle_push(const protocol::Message& message) {
  const protocol::AnswerSessions::Reception reception = answers_.accept(message.header);
  if (reception.verdict == protocol::AnswerSessions::Verdict::kRepeat) {
    (void)outbox_.add_request(reception.bytes);
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
    edges_ |= Fact::kLostPush;
    outbox_.drop_command();
    if (message.header.session >= protocol::kFirstReliableSession) {
      const core::Expected<protocol::Outgoing> answer =
          answers_.answer(message.header, protocol::encode_ack(protocol::kAckSuccess), config_.cipher);
      if (answer) {
        (void)outbox_.add_request(answer->bytes);
      }
    }
  }
}

void SerialLink::poll_sessions(core::TimePoint now) {
  for (std::size_t i = 0; i < protocol::kReliableSessions; ++i) {
    const core::Expected<protocol::Due> due = sessions_.poll(now);
    if (!due) {
      return;
    }
    if (due->kind == protocol::Due::Kind::kRepeat) {
      (void)outbox_.add_request(due->frame.bytes);  // a full outbox is a lost repetition: the next one follows
    } else {
      edges_ |= when(is_question_of(state_.stage, due->command), Fact::kNoAnswer);
    }
  }
}

bool SerialLink::recent(protocol::TelemetryItem item, core::TimePoint now, core::Duration age) const {
  return (seen_items_ & static_cast<std::uint16_t>(item)) != 0 && now - received_at(item) <= age;
}

core::TimePoint SerialLink::received_at(protocol::TelemetryItem item) const {
  std::size_t index = 0;
  while (index + 1 < item_times_.size() && ((std::uint32_t{static_cast<std::uint16_t>(item)} >> index) & 1U) == 0) {
    ++index;
  }
  return item_times_[index];
}

safety::Fact SerialLink::level_facts(core::TimePoint now) const {
  using Item = protocol::TelemetryItem;
  const protocol::Telemetry::Control& control = telemetry_.control;
  const bool uses_virtual_rc = config_.channel.channel == Channel::kVirtualRc;
  // While Virtual RC is on, the RC item may show our own mode channel (A) instead of the real switch (protocol, 7).
  // Then only the control item tells of the switch; where the item has shown F it is the switch.
  const bool shows_our_mode =
      uses_virtual_rc && !rc_item_is_real_ && control.virtual_rc_on() && telemetry_.rc.mode == protocol::kRcModeA;
  return when(ever_heard_ && now - last_frame_ <= kHeardFor, Fact::kHeard) |
         when(recent(Item::kRc, now, kHeardFor) && recent(Item::kControl, now, kHeardFor), Fact::kItemsFresh) |
         when(telemetry_.rc.mode == protocol::kRcModeF || shows_our_mode, Fact::kModeF) |
         when(telemetry_.rc.gear == 0, Fact::kRcOff) |
         when(control.device() == protocol::ControlDevice::kOnboardComputer, Fact::kDeviceOurs) |
         when(control.virtual_rc_on(), Fact::kVirtualRcOn) | when(uses_virtual_rc, Fact::kNeedsVirtualRc);
}

void SerialLink::step_authority(core::TimePoint now) {
  const Fact levels = level_facts(now);
  const safety::AuthorityStep made = safety::step(state_, levels | edges_, now - last_step_);
  edges_ = Fact::kNone;
  last_step_ = now;
  state_ = made.state;
  if (made.moved) {
    give_up_open_request();
  }
  commanded_ = commanded_ && safety::may_command(state_.stage);
  if (!safety::may_command(state_.stage) && outbox_.has_command()) {
    outbox_.drop_command();
    ++meter_.counters().commands_dropped;
  }
  act(made.action, now);
  authority_.stage = state_.stage;
  authority_.reason = state_.reason;
  authority_.in_control = safety::may_command(state_.stage);
  authority_.mode_f = safety::any(levels, Fact::kModeF);
  authority_.heard = safety::any(levels, Fact::kHeard);
  authority_.telemetry_fresh = meter_.health().packages > 0 && meter_.health().telemetry_age <= kFreshFor;
}

void SerialLink::give_up_open_request() {
  sessions_.cancel(protocol::ids::kVersionQuery);
  sessions_.cancel(protocol::ids::kActivation);
  sessions_.cancel(protocol::ids::kTelemetryFrequency);
  sessions_.cancel(protocol::ids::kControlRequest);
}

}  // namespace m100::app
