// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include "host_tests/sim/autopilot/n1_autopilot.h"
#include "protocol/bytes.h"
#include "protocol/dji/acks.h"
#include "protocol/dji/command_decoder.h"

namespace m100::sim {
namespace {

/// Codes above 5; 200 and 400 Hz are for newer aircraft (protocol, 4.3). The decoder treats them as "keep the rate".
bool has_unknown_rate(const protocol::Message& message) {
  const auto items = message.value.first(std::min(message.value.size(), protocol::kTelemetryItemCount));
  return message.id == protocol::ids::kTelemetryFrequency &&
         std::any_of(items.begin(), items.end(), [](std::byte code) { return code > std::byte{5}; });
}

N1Request asked_of(const protocol::Command& command, protocol::MessageId id) {
  if (const auto* request = std::get_if<protocol::ControlRequest>(&command)) {
    return request->obtain ? N1Request::kObtainControl : N1Request::kReleaseControl;
  }
  for (const N1RequestName& word : kN1RequestNames) {
    if (word.id == id) {
      return word.request;
    }
  }
  return N1Request::kAny;
}

}  // namespace

void N1Autopilot::handle(const protocol::FrameView& frame) {
  if (frame.header.is_ack) {
    return;  // the acknowledgement of a push in a session; this autopilot sends none
  }
  const protocol::AnswerSessions::Reception reception = sessions_.accept(frame.header);
  if (reception.verdict == protocol::AnswerSessions::Verdict::kRepeat) {
    acknowledge(reception.bytes, request_in_session_[frame.header.session]);
    return;
  }
  if (reception.verdict == protocol::AnswerSessions::Verdict::kIgnore) {
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
    emit("received", "version_query");
    answer(frame.header, version_answer(), config_.cipher, asked_of(*command, message->id));
    return;
  }
  if (!answered) {
    execute_unanswered(*command, message->id);
    return;
  }
  const bool needs_activation =
      config_.behaviour.answers.needs_activation && message->id.set == protocol::ids::kControlRequest.set;
  const std::uint16_t code = needs_activation && !activated_ ? protocol::kAckNotAuthorised : execute(*command);
  emit("answered", protocol::name(message->id), code);
  answer(frame.header, protocol::encode_ack(code), config_.cipher, asked_of(*command, message->id));
}

void N1Autopilot::refuse(const protocol::FrameHeader& header, const core::Expected<protocol::Message>& message) {
  ++record_.bad_commands;
  // With a wrong key every command deciphers into an unknown one; a known command was deciphered correctly.
  const bool undecipherable =
      header.encrypted() && (!message || !message->has_id || protocol::find(message->id) == nullptr);
  emit("ignored", undecipherable ? "undecipherable" : "bad_command", header.session);
  if (header.session == protocol::kUnansweredSession) {
    return;
  }
  if (undecipherable && !config_.behaviour.answers.wrong_key_in_plain) {
    return;
  }
  if (undecipherable) {
    // Plain, because the client has another key and could not read an encrypted answer.
    answer(header, protocol::encode_ack(protocol::kAckKeyError), nullptr, N1Request::kAny);
  } else if (message && message->has_id && message->id == protocol::ids::kTelemetryFrequency) {
    answer(header, protocol::encode_ack(1), config_.cipher, N1Request::kSetRates);  // a code above 5
  }
}

void N1Autopilot::answer(const protocol::FrameHeader& to, std::span<const std::byte> value,
                         const protocol::Cipher* cipher, N1Request request) {
  const core::Expected<protocol::Outgoing> frame = sessions_.answer(to, value, cipher);
  if (frame) {
    request_in_session_[to.session] = request;
    acknowledge(frame->bytes, request);
  }
}

bool N1Autopilot::loses_ack(N1Request request) {
  if (acks_to_lose_ == 0 || (acks_to_lose_of_ != N1Request::kAny && acks_to_lose_of_ != request)) {
    return false;
  }
  --acks_to_lose_;
  return true;
}

void N1Autopilot::acknowledge(std::span<const std::byte> frame, N1Request request) {
  if (loses_ack(request)) {
    emit("did", "lost_ack");
    return;
  }
  const int copies = acks_to_double_ > 0 ? 2 : 1;
  acks_to_double_ -= acks_to_double_ > 0 ? 1 : 0;
  for (int copy = 0; copy < copies; ++copy) {
    const core::Duration delay =
        ack_delay_ + core::Duration{static_cast<std::int64_t>(1e6 * config_.behaviour.answers.delay_s)};
    if (delay > core::Duration{0}) {
      line_.send_later(frame, time_ + delay);
    } else {
      (void)line_.send(frame, time_);
    }
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
    return set_rates(*wanted);
  }
  if (const auto* request = std::get_if<protocol::ControlRequest>(&command)) {
    return control(request->obtain);
  }
  if (const auto* request = std::get_if<protocol::MotorRequest>(&command)) {
    return motors(request->start);
  }
  if (const auto* request = std::get_if<protocol::TaskRequest>(&command)) {
    return start_task(*request);
  }
  if (const auto* query = std::get_if<protocol::TaskQuery>(&command)) {
    return task_result(*query);
  }
  return protocol::kAckSuccess;  // data to the mobile app
}

std::uint16_t N1Autopilot::activate(const protocol::Activation& activation) {
  emit("received", "activate", activation.app_id);
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

std::uint16_t N1Autopilot::set_rates(const protocol::TelemetryFrequency& wanted) {
  for (std::size_t item = 0; item < rates_.size() && config_.behaviour.telemetry.obeys_rates; ++item) {
    rates_[item] = wanted.rates[item] == protocol::Rate::kAsItIs ? rates_[item] : wanted.rates[item];
  }
  return protocol::kAckSuccess;
}

std::uint16_t N1Autopilot::control(bool obtain) {
  namespace ack = protocol::control_ack;
  if (!obtain) {
    emit("received", "release_control");
    if (!rc_in_f()) {
      return ack::kNotInModeF;  // the switch has already left F (protocol, section 11, state 8)
    }
    requested_once_ = false;  // after a release, control has to be requested twice again
    if (!client_in_control()) {
      return ack::kReleased;
    }
    release_requested_once_ = !release_requested_once_ && config_.behaviour.control.requests_to_release > 1.0;
    if (release_requested_once_) {
      return ack::kReleasing;
    }
    device_ = protocol::ControlDevice::kRemoteController;
    moving_ = false;
    lost_by_mode_ = false;
    end_task_with_control();
    authority_lost_ = false;  // given back, not taken
    emit("did", "released");
    return ack::kReleased;
  }
  emit("received", "obtain_control");
  ++record_.obtain_requests;
  if (record_.obtain_requests > 1) {
    record_.min_obtain_spacing = std::min(record_.min_obtain_spacing, time_ - last_obtain_);
  }
  last_obtain_ = time_;
  release_requested_once_ = false;
  if (!rc_in_f()) {
    return ack::kNotInModeF;
  }
  if (ioc_) {
    return ack::kIocActive;
  }
  if (client_in_control()) {
    return ack::kObtained;
  }
  if (mobile_wants_control_) {
    return ack::kObtaining;  // for as long as the app has control
  }
  requested_once_ = !requested_once_ && config_.behaviour.control.requests_to_obtain > 1.0;
  if (requested_once_) {
    return ack::kObtaining;
  }
  device_ = protocol::ControlDevice::kOnboardComputer;
  authority_lost_ = false;
  emit("did", "obtained");
  return ack::kObtained;
}

std::uint16_t N1Autopilot::motors(bool start) {
  if (!client_in_control()) {
    return protocol::motor_ack::kNeedsControl;
  }
  const VehicleState& state = vehicle_.state();
  if (state.motors_on == start) {
    return protocol::motor_ack::kAlready;
  }
  if (state.in_air) {
    return protocol::motor_ack::kInAir;
  }
  vehicle_.set_motors(start);
  return protocol::motor_ack::kDone;
}

std::uint16_t N1Autopilot::start_task(const protocol::TaskRequest& request) {
  const bool take_off = request.task == protocol::Task::kTakeOff;
  const VehicleState& state = vehicle_.state();
  const bool fits = take_off ? !state.in_air && !state.motors_on : state.in_air;  // protocol, 6.3: motors stopped
  emit("received", take_off ? "task_takeoff" : request.task == protocol::Task::kLand ? "task_land" : "task_go_home");
  if (!client_in_control() || tasks_ == 0.0 || !config_.behaviour.tasks.offered || !fits) {
    return protocol::task_ack::kRefused;
  }
  if (tasks_ == 2.0) {
    return protocol::task_ack::kStarted;
  }
  task_ = request.task;
  task_number_ = request.sequence;
  task_open_ = true;
  task_done_ = false;
  if (take_off) {
    vehicle_.set_motors(true);
  }
  return protocol::task_ack::kStarted;
}

std::uint16_t N1Autopilot::task_result(const protocol::TaskQuery& query) const {
  if (task_ == protocol::Task{} || query.sequence != task_number_) {
    return protocol::task_query_ack::kWrongNumber;
  }
  if (task_done_) {
    return protocol::task_query_ack::kSucceeded;
  }
  return task_open_ ? protocol::task_query_ack::kInProgress : protocol::task_query_ack::kFailed;
}

}  // namespace m100::sim
