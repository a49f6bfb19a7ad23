// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/app/serial_link.h"

#include <cmath>

#include "firmware/core/assert.h"
#include "protocol/catalogue.h"
#include "protocol/commands.h"
#include "protocol/pushes.h"

namespace m100::app {
namespace {

using safety::Action;
using safety::Fact;
using safety::Stage;
using safety::when;

/// Bytes per visit to the UART; several visits per tick.
constexpr std::size_t kChunkBytes = 512;
/// The autopilot counts 400 Hz ticks. A jump of more than this against our own clock means that it restarted.
constexpr core::Duration kClockTick = std::chrono::microseconds(2500);
constexpr core::Duration kClockJump = std::chrono::seconds(1);
/// DJI's thirty-two characters of the SDK of the M100's time (protocol, 4.2).
constexpr char kBundleCharacter = '9';
constexpr std::uint8_t kOnce = 1;

/// Which command's answer the stage is waiting for.
bool is_question_of(Stage stage, protocol::MessageId command) {
  switch (stage) {
    case Stage::kAskingVersion:
      return command == protocol::ids::kVersionQuery;
    case Stage::kActivating:
      return command == protocol::ids::kActivation;
    case Stage::kSettingRates:
      return command == protocol::ids::kTelemetryFrequency;
    case Stage::kObtaining:
    case Stage::kReleasing:
      return command == protocol::ids::kControlRequest;
    default:
      return false;
  }
}

/// Clears the bits of items that hold a number which is not finite, and says how many there were.
template <std::size_t kCount>
bool finite(const std::array<float, kCount>& values) {
  for (const float value : values) {
    if (!std::isfinite(value)) {
      return false;
    }
  }
  return true;
}

std::uint16_t not_finite_items(const protocol::Telemetry& telemetry) {
  using Item = protocol::TelemetryItem;
  std::uint16_t bad = 0;
  const auto judge = [&](Item item, bool good) {
    if (telemetry.has(item) && !good) {
      bad = static_cast<std::uint16_t>(bad | static_cast<std::uint16_t>(item));
    }
  };
  const protocol::Telemetry::Position& position = telemetry.position;
  judge(Item::kAttitude, finite(telemetry.attitude));
  judge(Item::kAcceleration, finite(telemetry.acceleration));
  judge(Item::kVelocity, finite(telemetry.velocity_ned_m_s));
  judge(Item::kAngularVelocity, finite(telemetry.angular_velocity_frd_rad_s));
  judge(Item::kPosition, std::isfinite(position.latitude_rad) && std::isfinite(position.longitude_rad) &&
                             std::isfinite(position.altitude_m) && std::isfinite(position.height_m));
  return bad;
}

/// Gives the items in `keep` back their former values.
void restore(protocol::Telemetry& telemetry, const protocol::Telemetry& former, std::uint16_t keep) {
  using Item = protocol::TelemetryItem;
  const auto kept = [&](Item item) { return (keep & static_cast<std::uint16_t>(item)) != 0; };
  if (kept(Item::kAttitude)) {
    telemetry.attitude = former.attitude;
  }
  if (kept(Item::kAcceleration)) {
    telemetry.acceleration = former.acceleration;
  }
  if (kept(Item::kVelocity)) {
    telemetry.velocity_ned_m_s = former.velocity_ned_m_s;
  }
  if (kept(Item::kAngularVelocity)) {
    telemetry.angular_velocity_frd_rad_s = former.angular_velocity_frd_rad_s;
  }
  if (kept(Item::kPosition)) {
    telemetry.position = former.position;
  }
  telemetry.items = static_cast<std::uint16_t>(telemetry.items & ~keep);
}

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
  parse(now);
  poll_sessions(now);
  step_authority(now);
  flush(now);
  meter_.tick(now);
  meter_.counters().parser = parser_.stats();
  meter_.counters().sessions = sessions_.stats();
  meter_.counters().overrun_bytes = ring_.dropped();
  return telemetry_;
}

void SerialLink::collect(core::TimePoint now) {
  std::array<std::byte, kChunkBytes> chunk;
  for (std::size_t visit = 0; visit < kRingBytes / kChunkBytes; ++visit) {
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
    for (const std::byte value : bytes) {
      (void)ring_.push(value);  // a full ring counts what it refuses
    }
  }
}

void SerialLink::parse(core::TimePoint now) {
  std::array<std::byte, kChunkBytes> chunk;
  for (std::size_t visit = 0; visit < kRingBytes / kChunkBytes + 1; ++visit) {
    const std::span<std::byte> bytes = ring_.pop_into(chunk);
    if (bytes.empty()) {
      return;
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
    handle_push(*message, now);
  }
}

void SerialLink::handle_telemetry(const protocol::Message& message, core::TimePoint now) {
  const protocol::Telemetry former = telemetry_;
  if (protocol::decode_telemetry(message.value, telemetry_) != core::Status::kOk) {
    ++meter_.counters().bad_packages;
    return;
  }
  const std::uint16_t bad = not_finite_items(telemetry_);
  for (std::uint16_t rest = bad; rest != 0; rest = static_cast<std::uint16_t>(rest & (rest - 1U))) {
    ++meter_.counters().refused_items;
  }
  restore(telemetry_, former, bad);
  meter_.package(now);
  for (std::size_t item = 0; item < item_times_.size(); ++item) {
    if ((telemetry_.items >> item & 1U) != 0) {
      item_times_[item] = now;
    }
  }
  if (telemetry_.has(protocol::TelemetryItem::kTime)) {
    watch_clock(now);
  }
  seen_items_ = static_cast<std::uint16_t>(seen_items_ | telemetry_.items);
  telemetry_.items = static_cast<std::uint16_t>(telemetry_.items | former.items);
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
  if (*code == protocol::kAckNotAuthorised || *code == protocol::kAckKeyError) {
    return Fact::kNotActivated;
  }
  // A request for control is answered by what was done, which may be the opposite of what was asked.
  const bool is_control = answer.command == protocol::ids::kControlRequest;
  const bool releasing = state_.stage == Stage::kReleasing;
  if (is_control && *code == (releasing ? protocol::control_ack::kObtained : protocol::control_ack::kReleased)) {
    return Fact::kRefused;
  }
  switch (authority_.answer.verdict) {
    case protocol::AckVerdict::kDone:
      return Fact::kDone;
    case protocol::AckVerdict::kSendAgain:
      return Fact::kAgain;
    case protocol::AckVerdict::kRetry:
      return Fact::kRetry;
    case protocol::AckVerdict::kRefused:
      break;
  }
  return Fact::kRefused;
}

void SerialLink::handle_push(const protocol::Message& message, core::TimePoint now) {
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
  (void)now;
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
  while (index + 1 < item_times_.size() && (static_cast<std::uint16_t>(item) >> index & 1U) == 0) {
    ++index;
  }
  return item_times_[index];
}

safety::Fact SerialLink::level_facts(core::TimePoint now) const {
  using Item = protocol::TelemetryItem;
  const protocol::Telemetry::Control& control = telemetry_.control;
  const bool uses_virtual_rc = config_.channel.channel == Channel::kVirtualRc;
  // While Virtual RC is on, the RC item may show our own mode channel (A) instead of the real switch (protocol, 7).
  const bool shows_our_mode = uses_virtual_rc && control.virtual_rc_on() && telemetry_.rc.mode == protocol::kRcModeA;
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

void SerialLink::act(safety::Action action, core::TimePoint now) {
  // Requests for control are sent once each: the table repeats them itself, two seconds apart.
  core::Status sent = core::Status::kOk;
  switch (action) {
    case Action::kNone:
      return;
    case Action::kAskVersion:
      sent = ask(protocol::VersionQuery{}, protocol::find(protocol::ids::kVersionQuery)->transmissions, now);
      break;
    case Action::kActivate: {
      protocol::Activation activation{
          .app_id = config_.app_id, .api_level = 2, .version = sdk_version_, .bundle_id = {}};
      activation.bundle_id.fill(kBundleCharacter);
      sent = ask(activation, protocol::find(protocol::ids::kActivation)->transmissions, now);
      break;
    }
    case Action::kSetRates:
      sent = ask(protocol::TelemetryFrequency{.rates = config_.rates},
                 protocol::find(protocol::ids::kTelemetryFrequency)->transmissions, now);
      break;
    case Action::kRequestControl:
      sent = ask(protocol::ControlRequest{.obtain = true}, kOnce, now);
      break;
    case Action::kSwitchVirtualRcOn:
      sent = tell(protocol::VirtualRcSwitch{.on = true, .fall_back_to_rc = true, .reserved = 0}, false, now);
      break;
    case Action::kReleaseControl:
      if (config_.channel.channel == Channel::kVirtualRc) {
        sent = tell(protocol::VirtualRcSwitch{.on = false, .fall_back_to_rc = true, .reserved = 0}, false, now);
      }
      if (sent == core::Status::kOk) {
        sent = ask(protocol::ControlRequest{.obtain = false}, kOnce, now);
      }
      break;
  }
  edges_ |= when(sent != core::Status::kOk, Fact::kNoAnswer);
}

template <typename Command>
core::Status SerialLink::ask(const Command& command, std::uint8_t transmissions, core::TimePoint now) {
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
core::Status SerialLink::tell(const Command& command, bool is_control, core::TimePoint) {
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
  if (!limiter_.due(now)) {
    return core::Status::kNotReady;
  }
  const bool replaces = outbox_.has_command();
  const core::Status made = is_sticks ? tell(to_virtual_rc(std::get<vrc::Sticks>(command)), true, now)
                                      : tell(to_movement(std::get<ctl::Command<double>>(command)), true, now);
  if (made != core::Status::kOk) {
    ++meter_.counters().commands_refused;
    return made;
  }
  meter_.counters().commands_dropped += replaces ? 1U : 0U;
  ++meter_.counters().commands_sent;
  limiter_.sent(now);
  flush(now);
  return core::Status::kOk;
}

void SerialLink::flush(core::TimePoint now) {
  const core::Status status = outbox_.flush(uart_, [&](std::span<const std::byte> bytes) {
    meter_.sent(bytes.size());
    if (tap_ != nullptr) {
      tap_->sent(bytes, now);
    }
  });
  if (status != core::Status::kOk) {
    outbox_.drop_all();  // the port is gone: what waits would be stale when it is back
  }
}

void SerialLink::request_control(core::TimePoint) { edges_ |= Fact::kAsked; }

void SerialLink::release(core::TimePoint) { edges_ |= Fact::kReleaseAsked; }

core::Status SerialLink::request(const protocol::MotorRequest& request, core::TimePoint now) {
  const bool possible = authority_.in_control && !sessions_.is_open(id_of(request));
  return possible ? ask(request, protocol::find(id_of(request))->transmissions, now) : core::Status::kRefused;
}

core::Status SerialLink::request(const protocol::TaskRequest& request, core::TimePoint now) {
  const bool possible = authority_.in_control && !sessions_.is_open(id_of(request));
  return possible ? ask(request, protocol::find(id_of(request))->transmissions, now) : core::Status::kRefused;
}

}  // namespace m100::app
