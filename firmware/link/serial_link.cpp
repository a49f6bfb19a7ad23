// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/link/serial_link.h"

#include "firmware/core/assert.h"
#include "firmware/link/answer_meaning.h"
#include "protocol/catalogue.h"

namespace m100::link {
namespace {

using safety::AuthoritySign;
using safety::when;

core::Duration period_or_assert(const ChannelConfig& config) {
  const core::Expected<core::Duration> period = command_period(config);
  M100_ASSERT(period.has_value());
  return *period;
}

}  // namespace

SerialLink::SerialLink(hal::Uart& uart, const LinkConfig& config, ByteTap* tap)
    : uart_(uart),
      config_(config),
      tap_(tap),
      candidates_(config.baud),
      limiter_(period_or_assert(config.channel)),
      meter_(config.baud) {}

const protocol::Telemetry& SerialLink::receive(core::TimePoint now) {
  telemetry_.items = 0;
  collect(now);
  if (!behind_) {
    poll_sessions(now);
    step_authority(now);
    listen_for_an_echo(now);
    flush(now);
  }
  meter_.tick(now);
  meter_.counters().parser = parser_.stats();
  meter_.counters().sessions = sessions_.stats();
  return telemetry_;
}

void SerialLink::poll_sessions(core::TimePoint now) {
  for (std::size_t i = 0; i < protocol::kReliableSessions; ++i) {
    const core::Expected<protocol::Due> due = sessions_.poll(now);
    if (!due) {
      return;
    }
    if (due->kind == protocol::Due::Kind::kRepeat) {
      (void)outbox_.add_request(due->frame.bytes);  // with a full outbox this retry is lost: the next one follows
    } else {
      edges_ |= when(is_question_of(state_.stage, due->command), AuthoritySign::kNoAnswer);
    }
  }
}

void SerialLink::listen_for_an_echo(core::TimePoint now) {
  const bool is_asked = sessions_.is_open(protocol::ids::kVersionQuery);
  if (authority_.in_control && !is_asked && now - last_echo_ >= kEchoSpacing) {
    (void)ask(protocol::VersionQuery{}, kEchoTransmissions, now);  // a query that cannot leave gets no answer either
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

safety::AuthoritySign SerialLink::level_signs(core::TimePoint now) const {
  using Item = protocol::TelemetryItem;
  const protocol::Telemetry::Control& control = telemetry_.control;
  const bool uses_virtual_rc = config_.channel.channel == Channel::kVirtualRc;
  // While Virtual RC is on, the RC item may show our own mode channel (A) instead of the real switch (protocol, 7).
  // Then only the control item shows the switch. Once the RC item has shown F, it shows the real switch.
  const bool shows_our_mode =
      uses_virtual_rc && !rc_item_is_real_ && control.virtual_rc_on() && telemetry_.rc.mode == protocol::kRcModeA;
  return when(ever_heard_ && now - last_frame_ <= kHeardFor, AuthoritySign::kHeard) |
         when(recent(Item::kRc, now, kHeardFor) && recent(Item::kControl, now, kHeardFor), AuthoritySign::kItemsFresh) |
         when(telemetry_.rc.mode == protocol::kRcModeF || shows_our_mode, AuthoritySign::kModeF) |
         when(telemetry_.rc.gear == 0, AuthoritySign::kRcOff) |
         when(control.device() == protocol::ControlDevice::kOnboardComputer, AuthoritySign::kDeviceOurs) |
         when(control.virtual_rc_on(), AuthoritySign::kVirtualRcOn) |
         when(uses_virtual_rc, AuthoritySign::kNeedsVirtualRc);
}

void SerialLink::step_authority(core::TimePoint now) {
  const AuthoritySign levels = level_signs(now);
  edges_ |= when(now - last_step_ > kOwnStall, AuthoritySign::kOwnStall);
  const safety::AuthorityStep made = safety::step(state_, levels | edges_, now - last_step_);
  edges_ = AuthoritySign::kNone;
  last_step_ = now;
  state_ = made.state;
  if (made.moved) {
    give_up_open_request();
    outbox_.drop_requests();  // requests that have not left yet are void as well
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
  authority_.asked = state_.asked;
  authority_.owed = state_.owed;
  authority_.port_gone = port_was_gone_;
  authority_.mode_f = safety::any(levels, AuthoritySign::kModeF);
  authority_.heard = safety::any(levels, AuthoritySign::kHeard);
  authority_.telemetry_fresh = meter_.health().packages > 0 && meter_.health().telemetry_age <= kFreshFor;
}

void SerialLink::give_up_open_request() {
  sessions_.cancel(protocol::ids::kVersionQuery);
  sessions_.cancel(protocol::ids::kActivation);
  sessions_.cancel(protocol::ids::kTelemetryFrequency);
  sessions_.cancel(protocol::ids::kControlRequest);
  sessions_.cancel(protocol::ids::kTask);
}

}  // namespace m100::link
