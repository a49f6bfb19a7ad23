// SPDX-License-Identifier: BSD-3-Clause
// The sending half of SerialLink: actions of the authority table, the operator's requests, and flight commands.
#include "firmware/link/serial_link.h"
#include "protocol/dji/catalogue.h"
#include "protocol/dji/commands.h"

namespace m100::link {
namespace {

using safety::AuthorityAction;
using safety::AuthorityCondition;
using safety::when;

/// DJI's thirty-two characters of the SDK of the M100's time (protocol, 4.2).
constexpr char kBundleCharacter = '9';
constexpr std::uint8_t kOnce = 1;

protocol::TelemetryFrequency wanted_rates(const std::array<protocol::Rate, 16>& rates,
                                          protocol::TelemetryLayout layout) {
  protocol::TelemetryFrequency wanted;
  const std::array<std::uint8_t, 16> places = protocol::rate_places(layout);
  for (std::size_t item = 0; item < rates.size(); ++item) {
    if (places[item] < wanted.rates.size()) {
      wanted.rates[places[item]] = rates[item];
    }
  }
  return wanted;
}

std::uint8_t usual_transmissions(protocol::MessageId id) { return protocol::find(id)->transmissions; }

}  // namespace

void SerialLink::act(safety::AuthorityAction action, core::TimePoint now) {
  // Requests for control are sent once each: the table repeats them itself, two seconds apart.
  core::Status sent = core::Status::kOk;
  switch (action) {
    case AuthorityAction::kNone:
      return;
    case AuthorityAction::kRequestVersion:
      sent = send_request(protocol::VersionQuery{}, usual_transmissions(protocol::ids::kVersionQuery), now);
      break;
    case AuthorityAction::kActivate: {
      protocol::Activation activation{
          .app_id = config_.app_id, .api_level = 2, .version = sdk_version_, .bundle_id = {}};
      activation.bundle_id.fill(kBundleCharacter);
      sent = send_request(activation, usual_transmissions(protocol::ids::kActivation), now);
      break;
    }
    case AuthorityAction::kSetRates:
      sent = send_request(wanted_rates(config_.rates, layout_), usual_transmissions(protocol::ids::kTelemetryFrequency),
                          now);
      break;
    case AuthorityAction::kRequestControl:
      sent = send_request(protocol::ControlRequest{.obtain = true}, kOnce, now);
      break;
    case AuthorityAction::kSwitchVirtualRcOn:
      sent = transmit(protocol::VirtualRcSwitch{.on = true, .fall_back_to_rc = true, .reserved = 0}, false);
      break;
    case AuthorityAction::kReleaseControl:
      (void)send_release(now);  // the table retries a release that did not leave
      break;
  }
  edges_ |= when(sent != core::Status::kOk, AuthorityCondition::kNoAnswer);
}

core::Status SerialLink::send_release(core::TimePoint now) {
  if (outbox_.has_requests()) {
    return core::Status::kNotReady;  // the line is stuck: only one release waits for it, not many
  }
  if (config_.channel.channel == Channel::kVirtualRc || telemetry_.control.virtual_rc_on()) {
    const core::Status sent =
        transmit(protocol::VirtualRcSwitch{.on = false, .fall_back_to_rc = true, .reserved = 0}, false);
    if (sent != core::Status::kOk) {
      return sent;
    }
  }
  sessions_.cancel(protocol::ids::kControlRequest);
  return send_request(protocol::ControlRequest{.obtain = false}, kOnce, now);
}

template <typename Command>
core::Status SerialLink::send_request(const Command& command, std::uint8_t transmissions, core::TimePoint now) {
  const core::Expected<protocol::Value> value = encode(command);
  if (!value) {
    return value.status();
  }
  const protocol::MessageId id = id_of(command);
  const bool encrypted = config_.encrypt_commands && id.set != protocol::ids::kVersionQuery.set;
  protocol::RequestOptions options = protocol::options_for(*protocol::find(id), encrypted ? config_.cipher : nullptr);
  options.transmissions = transmissions;
  const core::Expected<protocol::Outgoing> frame = sessions_.request(id, *value, options, now);
  if (!frame) {
    return frame.status();
  }
  return outbox_.add_request(frame->bytes) ? core::Status::kOk : core::Status::kResourceExhausted;
}
// serial_link.cpp uses this instance; a compiler that inlines every use here would not emit it.
template core::Status SerialLink::send_request(const protocol::VersionQuery&, std::uint8_t, core::TimePoint);

template <typename Command>
core::Status SerialLink::transmit(const Command& command, bool is_control) {
  const core::Expected<protocol::Value> value = encode(command);
  if (!value) {
    return value.status();
  }
  const core::Expected<protocol::Outgoing> frame =
      sessions_.send(id_of(command), *value, config_.encrypt_commands ? config_.cipher : nullptr);
  if (!frame) {
    return frame.status();
  }
  const bool taken = is_control ? outbox_.set_command(frame->bytes) : outbox_.add_request(frame->bytes);
  return taken ? core::Status::kOk : core::Status::kResourceExhausted;
}

core::Status SerialLink::send(const ChannelCommand& command, core::TimePoint now) {
  const bool is_sticks = std::holds_alternative<vrc::Sticks>(command);
  if (is_sticks != (config_.channel.channel == Channel::kVirtualRc)) {
    return core::Status::kInvalidArgument;
  }
  if (!authority_.in_control) {
    ++meter_.counters().commands_refused;
    return core::Status::kRefused;
  }
  if (behind_ || !limiter_.due(now)) {
    return core::Status::kNotReady;
  }
  const bool replaces = outbox_.has_command();
  const core::Status made = is_sticks ? transmit(to_virtual_rc(std::get<vrc::Sticks>(command)), true)
                                      : transmit(to_movement(std::get<ctl::Command<double>>(command)), true);
  if (made != core::Status::kOk) {
    ++meter_.counters().commands_refused;
    return made;
  }
  meter_.counters().commands_dropped += replaces ? 1U : 0U;
  ++meter_.counters().commands_sent;
  limiter_.sent(now);
  first_command_ = commanded_ ? first_command_ : now;
  commanded_ = true;
  flush(now);
  return core::Status::kOk;
}

void SerialLink::flush(core::TimePoint now) {
  const bool command_waits = outbox_.has_command();
  const core::Status status = outbox_.flush(uart_, [&](std::span<const std::byte> bytes) {
    meter_.sent(bytes.size());
    if (tap_ != nullptr) {
      tap_->sent(bytes, now);
    }
  });
  if (command_waits && !outbox_.has_command()) {
    limiter_.left(now);
  }
  if (status != core::Status::kOk) {
    outbox_.drop_all();  // the port is gone: waiting frames would be stale when it is back
  }
}

void SerialLink::request_control(core::TimePoint) { edges_ |= AuthorityCondition::kControlRequested; }

void SerialLink::release(core::TimePoint) { edges_ |= AuthorityCondition::kReleaseRequested; }

core::Status SerialLink::request(const protocol::MotorRequest& request, core::TimePoint now) {
  const bool possible = authority_.in_control && !sessions_.is_open(id_of(request));
  return possible ? send_request(request, usual_transmissions(id_of(request)), now) : core::Status::kRefused;
}

core::Status SerialLink::request(const protocol::TaskRequest& request, core::TimePoint now) {
  const bool possible = authority_.in_control && !sessions_.is_open(id_of(request));
  authority_.answer = possible ? protocol::AckMeaning{} : authority_.answer;
  return possible ? send_request(request, usual_transmissions(id_of(request)), now) : core::Status::kRefused;
}

}  // namespace m100::link
