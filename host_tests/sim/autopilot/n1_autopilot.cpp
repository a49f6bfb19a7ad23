// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/autopilot/n1_autopilot.h"

#include <algorithm>
#include <string_view>

#include "host_tests/sim/autopilot/n1_script_syntax.h"
#include "protocol/dji/acks.h"
#include "protocol/dji/command_decoder.h"
#include "protocol/dji/pushes.h"

namespace m100::sim {
namespace {

constexpr std::uint32_t kTicksPerSlot = 4;  // telemetry slots of 10 ms

/// The event name of a script word. Empty for the remote controller, a restart, the sticks and a mode that changes:
/// these report themselves, with their effect.
std::string_view word_of(N1EventKind what, double value, N1Mode mode) {
  if (what == N1EventKind::kRc || what == N1EventKind::kRestart ||
      (what == N1EventKind::kMode && static_cast<N1Mode>(static_cast<char>(value)) != mode)) {
    return "";
  }
  if (what == N1EventKind::kTake) {
    return static_cast<char>(value) == 'm' ? "take_mobile" : "take_rc";
  }
  const auto* const form =
      std::find_if(kN1Events.begin(), kN1Events.end(), [&](const N1EventSyntax& one) { return one.what == what; });
  return form == kN1Events.end() ? "" : form->name;
}

}  // namespace

N1Autopilot::N1Autopilot(hal::Uart& uart, VehiclePort& vehicle, const N1Config& config)
    : vehicle_(vehicle),
      config_(config),
      clock_(config.clock_drift_ppm),
      log_(clock_),
      line_(uart, config.baud, config.seed),
      acknowledgements_(log_, line_, duration_of_seconds(config.behaviour.answers.delay_s)),
      record_(log_),
      controls_(
          log_, line_, record_, vehicle,
          {.behaviour = config_.behaviour, .mode = config.mode, .pilot_holds_position = config.pilot_holds_position}),
      telemetry_(config_.behaviour.telemetry, config.rates, config.noise, config.seed) {}

void N1Autopilot::advance(core::TimePoint now) {
  while (ticks_next() <= now) {
    step(clock_.tick());
  }
}

void N1Autopilot::step(core::Duration passed) {
  while (next_line_ < config_.script.size() && clock_.now() >= config_.script[next_line_].at) {
    happen(config_.script[next_line_]);
    ++next_line_;
  }
  receive();
  controls_.update();
  vehicle_.advance(passed);
  if (clock_.now() >= off_until_) {
    const bool speaks = activated_ || config_.behaviour.telemetry.before_activation;
    if (speaks && clock_.ticks_since_boot() % kTicksPerSlot == 0) {
      send_telemetry();
    }
    line_.pump(clock_.now());
  }
}

void N1Autopilot::receive() {
  // One read returns few bytes when the line is paced; eight reads take all that have arrived.
  for (int visit = 0; visit < 8; ++visit) {
    const std::span<const std::byte> bytes = line_.read(clock_.now());
    if (bytes.empty()) {
      return;
    }
    if (clock_.now() >= off_until_) {
      parser_.consume(bytes, [this](const protocol::FrameView& frame) {
        if (!line_.loses_incoming()) {
          handle(frame);
        }
      });
    }
  }
}

void N1Autopilot::happen(const N1ScriptLine& line) {
  if (line.what == N1EventKind::kStick) {
    log_.emit("did", "stick", line.move.counts);
    controls_.transmitter().move(line.move);
  } else if (line.what == N1EventKind::kSensorFault) {
    log_.emit("did", line.fault->name, line.value);
    start_sensor_fault(*line.fault, line.value);
  } else {
    happen(line.what, line.value, line.request);
  }
}

void N1Autopilot::happen(N1EventKind what, double value, N1Request request) {
  if (const std::string_view word = word_of(what, value, controls_.authority().mode()); !word.empty()) {
    log_.emit("did", word, what == N1EventKind::kMode ? rc_mode(controls_.authority().mode()) : value);
  }
  switch (what) {
    case N1EventKind::kMode:
      controls_.authority().set_wanted_mode(static_cast<N1Mode>(static_cast<char>(value)));
      break;
    case N1EventKind::kRc:
      controls_.switch_transmitter(value != 0.0);
      break;
    case N1EventKind::kTake:
      controls_.take_control(static_cast<char>(value) == 'm');
      break;
    case N1EventKind::kRestart:
      restart();
      break;
    case N1EventKind::kSilence:
      telemetry_.set_silent_until(clock_.now() + duration_of_seconds(value));
      break;
    case N1EventKind::kLoseAcks:
      acknowledgements_.lose(static_cast<std::uint32_t>(value), request);
      break;
    case N1EventKind::kDelayAcks:
      acknowledgements_.set_delay(duration_of_seconds(value));
      break;
    case N1EventKind::kDoubleAcks:
      acknowledgements_.send_twice(static_cast<std::uint32_t>(value));
      break;
    case N1EventKind::kNoise:
      line_.make_noise(static_cast<std::size_t>(value));
      break;
    case N1EventKind::kLoss:
      line_.set_loss(value);
      break;
    case N1EventKind::kIoc:
      controls_.authority().set_ioc(value != 0.0);
      break;
    case N1EventKind::kActivation:
      forced_activation_ = static_cast<std::uint16_t>(value);
      break;
    case N1EventKind::kTasks:
      controls_.task().set_behaviour(value);
      break;
    case N1EventKind::kEndTask:
      controls_.task().end();
      break;
    case N1EventKind::kPose:
      pose_on_ = value != 0.0;
      break;
    case N1EventKind::kEndVirtualRc:
      controls_.end_virtual_rc("ended_by_script");
      break;
    case N1EventKind::kStick:
    case N1EventKind::kSensorFault:
      break;  // these need the stick movement or the sensor fault of a script line
  }
}

void N1Autopilot::handle(const protocol::FrameView& frame) {
  if (frame.header.is_ack) {
    return;  // the acknowledgement of a push in a session; this autopilot sends none
  }
  if (!acknowledgements_.accept(frame.header)) {
    return;
  }
  const bool answered = frame.header.session != protocol::kUnansweredSession;
  const core::Expected<protocol::Message> message = protocol::open(frame, config_.cipher, scratch_);
  const core::Expected<protocol::Command> command =
      message && message->has_id && !has_unknown_rate(*message)
          ? protocol::decode_command(message->id, message->value)
          : core::Expected<protocol::Command>(core::Status::kInvalidArgument);
  if (!message || !command) {
    refuse(frame.header, message);
    return;
  }
  if (std::holds_alternative<protocol::VersionQuery>(*command) && answered) {
    log_.emit("received", "version_query");
    acknowledgements_.answer(frame.header, version_answer(), config_.cipher, request_of(*command, message->id));
    return;
  }
  if (!answered) {
    execute_unanswered(*command, message->id);
    return;
  }
  const bool needs_activation =
      config_.behaviour.answers.needs_activation && message->id.set == protocol::ids::kControlRequest.set;
  const std::uint16_t code = needs_activation && !activated_ ? protocol::kAckNotAuthorised : execute(*command);
  log_.emit("answered", protocol::name(message->id), code);
  acknowledgements_.answer(frame.header, protocol::encode_ack(code), config_.cipher, request_of(*command, message->id));
}

void N1Autopilot::refuse(const protocol::FrameHeader& header, const core::Expected<protocol::Message>& message) {
  ++record_.counts().bad_commands;
  // With a wrong key every command deciphers into an unknown one; a known command was deciphered correctly.
  const bool undecipherable =
      header.encrypted() && (!message || !message->has_id || protocol::find(message->id) == nullptr);
  log_.emit("ignored", undecipherable ? "undecipherable" : "bad_command", header.session);
  if (header.session == protocol::kUnansweredSession) {
    return;
  }
  if (undecipherable && !config_.behaviour.answers.wrong_key_in_plain) {
    return;
  }
  if (undecipherable) {
    // Plain, because the client has another key and could not read an encrypted answer.
    acknowledgements_.answer(header, protocol::encode_ack(protocol::kAckKeyError), nullptr, N1Request::kAny);
  } else if (message && message->has_id && message->id == protocol::ids::kTelemetryFrequency) {
    acknowledgements_.answer(header, protocol::encode_ack(1), config_.cipher, N1Request::kSetRates);  // a code above 5
  }
}

protocol::Value N1Autopilot::version_answer() const {
  constexpr std::string_view kId = "0123456789";
  constexpr std::string_view kText = "SDK-v1.0 BETA M100-03.01.01.00";  // protocol, 4.1: read as 3.1.10.0
  protocol::VersionAnswer reply;
  reply.code = activated_ ? protocol::kAckSuccess : protocol::kAckNotAuthorised;
  reply.version_crc = 0xA6453AAC;
  std::copy(kId.begin(), kId.end(), reply.device_id.begin());
  std::copy(kText.begin(), kText.end(), reply.version_name.begin());
  return encode(reply);
}

std::uint16_t N1Autopilot::execute(const protocol::Command& command) {
  if (const auto* activation = std::get_if<protocol::Activation>(&command)) {
    return activate(*activation);
  }
  if (const auto* wanted = std::get_if<protocol::TelemetryFrequency>(&command)) {
    telemetry_.set_rates(*wanted);
    return protocol::kAckSuccess;
  }
  if (const auto* request = std::get_if<protocol::ControlRequest>(&command)) {
    return controls_.request_control(request->obtain);
  }
  if (const auto* request = std::get_if<protocol::MotorRequest>(&command)) {
    return controls_.switch_motors(request->start);
  }
  if (const auto* request = std::get_if<protocol::TaskRequest>(&command)) {
    return controls_.task().start(*request, client_in_control());
  }
  if (const auto* query = std::get_if<protocol::TaskQuery>(&command)) {
    return controls_.task().result(*query);
  }
  return protocol::kAckSuccess;  // data to the mobile app
}

void N1Autopilot::execute_unanswered(const protocol::Command& command, protocol::MessageId id) {
  // Sets 0x04 and 0x05 are ignored before activation [inferred]; session 0 cannot report that.
  if (!activated_) {
    log_.emit("ignored", protocol::name(id));
    return;
  }
  if (const auto* movement = std::get_if<protocol::Movement>(&command)) {
    controls_.set_movement(*movement);
  } else if (const auto* wanted = std::get_if<protocol::VirtualRcSwitch>(&command)) {
    controls_.switch_virtual_rc(*wanted);
  } else if (const auto* data = std::get_if<protocol::VirtualRcData>(&command)) {
    controls_.virtual_rc().update(*data);
  } else {
    log_.emit("received", protocol::name(id));
  }
}

std::uint16_t N1Autopilot::activate(const protocol::Activation& activation) {
  log_.emit("received", "activate", activation.app_id);
  if (forced_activation_ != 0) {
    return forced_activation_;
  }
  if (activation.version != kVersion) {
    return protocol::activation_ack::kVersionMismatch;
  }
  if (config_.app_id != 0 && activation.app_id != config_.app_id) {
    return protocol::activation_ack::kServerRefused;
  }
  activated_ = true;
  return protocol::activation_ack::kActivated;
}

void N1Autopilot::restart() {
  log_.emit("did", "restart");
  controls_.restart();
  activated_ = false;
  acknowledgements_.restart();
  parser_ = protocol::FrameParser();
  line_.clear();
  off_until_ = clock_.now() + duration_of_seconds(config_.behaviour.telemetry.silent_after_restart_s);
  clock_.restart();
  telemetry_.restart();
}

void N1Autopilot::send_telemetry() {
  std::optional<protocol::Telemetry> telemetry = telemetry_.next(vehicle_, clock_.ticks_since_boot(), clock_.now());
  if (!telemetry) {
    return;
  }
  controls_.report(*telemetry);
  telemetry_.apply_fault(*telemetry);
  line_.push(protocol::ids::kTelemetry, encode(*telemetry), clock_.now());
  ++record_.counts().telemetry_packages;
}

}  // namespace m100::sim
