// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/link/command_writer.h"

#include "protocol/dji/catalogue.h"

namespace m100::link {
namespace {

using safety::AuthorityAction;

/// DJI's SDK of the M100's time sends thirty-two of these characters as its bundle id (protocol, 4.2).
constexpr char kBundleCharacter = '9';
constexpr std::uint8_t kOnce = 1;

protocol::TelemetryFrequency wanted_rates(const std::array<protocol::Rate, 12>& rates,
                                          protocol::TelemetryLayout layout) {
  protocol::TelemetryFrequency wanted;
  const std::array<std::uint8_t, 12> places = protocol::rate_places(layout);
  for (std::size_t item = 0; item < rates.size(); ++item) {
    wanted.rates[places[item]] = rates[item];
  }
  return wanted;
}

std::uint8_t usual_transmissions(protocol::MessageId id) { return protocol::find(id)->transmissions; }

}  // namespace

core::Status CommandWriter::perform(AuthorityAction action, const protocol::VersionAnswer& version,
                                    protocol::TelemetryLayout layout, bool virtual_rc_on, core::TimePoint now) {
  // Requests for control are sent once each: the table repeats them itself, two seconds apart.
  switch (action) {
    case AuthorityAction::kNone:
      return core::Status::kOk;
    case AuthorityAction::kRequestVersion:
      return request(protocol::VersionQuery{}, usual_transmissions(protocol::ids::kVersionQuery), now);
    case AuthorityAction::kActivate: {
      protocol::Activation activation{
          .app_id = config_.app_id, .version = protocol::sdk_version(version).value_or(0), .bundle_id = {}};
      activation.bundle_id.fill(kBundleCharacter);
      return request(activation, usual_transmissions(protocol::ids::kActivation), now);
    }
    case AuthorityAction::kSetRates:
      return request(wanted_rates(config_.rates, layout), usual_transmissions(protocol::ids::kTelemetryFrequency), now);
    case AuthorityAction::kRequestControl:
      return request(protocol::ControlRequest{.obtain = true}, kOnce, now);
    case AuthorityAction::kSwitchVirtualRcOn:
      return transmit(protocol::VirtualRcSwitch{.on = true, .fall_back_to_rc = true, .reserved = 0}, false);
    case AuthorityAction::kReleaseControl:
      (void)release(virtual_rc_on, now);
      return core::Status::kOk;
  }
  return core::Status::kOk;
}

core::Status CommandWriter::release(bool virtual_rc_on, core::TimePoint now) {
  if (outbox_.has_requests()) {
    return core::Status::kNotReady;  // the line has not taken what waits: a release would only lengthen the queue
  }
  if (config_.uses_virtual_rc() || virtual_rc_on) {
    const core::Status sent =
        transmit(protocol::VirtualRcSwitch{.on = false, .fall_back_to_rc = true, .reserved = 0}, false);
    if (sent != core::Status::kOk) {
      return sent;
    }
  }
  sessions_.cancel(protocol::ids::kControlRequest);
  return request(protocol::ControlRequest{.obtain = false}, kOnce, now);
}

core::Status CommandWriter::request_echo(core::TimePoint now) {
  return request(protocol::VersionQuery{}, kEchoTransmissions, now);
}

core::Status CommandWriter::request(const protocol::MotorRequest& motors, core::TimePoint now) {
  return is_open(id_of(motors)) ? core::Status::kRefused : request(motors, usual_transmissions(id_of(motors)), now);
}

core::Status CommandWriter::request(const protocol::TaskRequest& task, core::TimePoint now) {
  return is_open(id_of(task)) ? core::Status::kRefused : request(task, usual_transmissions(id_of(task)), now);
}

core::Status CommandWriter::write(const ChannelCommand& command) {
  return std::holds_alternative<vrc::Sticks>(command)
             ? transmit(to_virtual_rc(std::get<vrc::Sticks>(command)), true)
             : transmit(to_movement(std::get<ctl::Command<double>>(command)), true);
}

void CommandWriter::cancel_requests() {
  sessions_.cancel_all();
  outbox_.drop_requests();
}

template <typename Command>
core::Status CommandWriter::request(const Command& command, std::uint8_t transmissions, core::TimePoint now) {
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

template <typename Command>
core::Status CommandWriter::transmit(const Command& command, bool is_control) {
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

bool CommandWriter::flush(core::TimePoint now, LinkMeter& meter) {
  const bool command_waits = outbox_.has_command();
  const core::Status status = outbox_.flush(uart_, [&](std::span<const std::byte> bytes) {
    meter.sent(bytes.size());
    if (tap_ != nullptr) {
      tap_->sent(bytes, now);
    }
  });
  const bool command_left = command_waits && !outbox_.has_command();
  if (status != core::Status::kOk) {
    outbox_.drop_all();  // the port is gone: waiting frames would be stale when it is back
  }
  return command_left;
}

}  // namespace m100::link
