// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/link/serial_link.h"

#include "firmware/core/assert.h"
#include "firmware/link/ack_condition.h"
#include "protocol/dji/catalogue.h"

namespace m100::link {
namespace {

using safety::AuthorityCondition;
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
    check_uplink(now);
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
      edges_ |= when(awaits_ack_of(state_.stage, due->command), AuthorityCondition::kNoAnswer);
    }
  }
}

void SerialLink::check_uplink(core::TimePoint now) {
  const bool is_asked = sessions_.is_open(protocol::ids::kVersionQuery);
  if (authority_.in_control && !is_asked && now - last_echo_ >= kEchoSpacing) {
    (void)send_request(protocol::VersionQuery{}, kEchoTransmissions,
                       now);  // a query that cannot leave gets no answer either
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

safety::AuthorityCondition SerialLink::level_conditions(core::TimePoint now) const {
  using Item = protocol::TelemetryItem;
  const protocol::Telemetry::Control& control = telemetry_.control;
  const bool uses_virtual_rc = config_.channel.channel == Channel::kVirtualRc;
  // While Virtual RC is on, the RC item may show our own mode channel (A) instead of the real switch (protocol, 7).
  // Then only the control item shows the switch. Once the RC item has shown F, it shows the real switch.
  const bool shows_our_mode =
      uses_virtual_rc && !rc_item_is_real_ && control.virtual_rc_on() && telemetry_.rc.mode == protocol::kRcModeA;
  return when(ever_received_ && now - last_frame_ <= kLinkTimeout, AuthorityCondition::kLinkAlive) |
         when(recent(Item::kRc, now, kLinkTimeout) && recent(Item::kControl, now, kLinkTimeout),
              AuthorityCondition::kItemsFresh) |
         when(telemetry_.rc.mode == protocol::kRcModeF || shows_our_mode, AuthorityCondition::kModeF) |
         when(telemetry_.rc.gear == 0, AuthorityCondition::kRcOff) |
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
    cancel_open_request();
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
  authority_.control_requested = state_.control_requested;
  authority_.release_pending = state_.release_pending;
  authority_.port_gone = port_was_gone_;
  authority_.mode_f = safety::any(levels, AuthorityCondition::kModeF);
  authority_.link_alive = safety::any(levels, AuthorityCondition::kLinkAlive);
  authority_.telemetry_fresh = meter_.health().packages > 0 && meter_.health().telemetry_age <= kFreshFor;
}

void SerialLink::cancel_open_request() {
  sessions_.cancel(protocol::ids::kVersionQuery);
  sessions_.cancel(protocol::ids::kActivation);
  sessions_.cancel(protocol::ids::kTelemetryFrequency);
  sessions_.cancel(protocol::ids::kControlRequest);
  sessions_.cancel(protocol::ids::kTask);
}

}  // namespace m100::link
