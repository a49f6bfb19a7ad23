// SPDX-License-Identifier: BSD-3-Clause
// The receiving half of SerialLink: bytes to frames, frames to telemetry, answers and pushes.
#include <algorithm>

#include "firmware/link/ack_condition.h"
#include "firmware/link/serial_link.h"
#include "firmware/link/telemetry_check.h"
#include "protocol/dji/pushes.h"

namespace m100::link {
namespace {

using safety::AuthorityCondition;

/// Messages that only a computer sends.
bool is_our_question(protocol::MessageId id) {
  return id == protocol::ids::kVersionQuery || id == protocol::ids::kActivation || id == protocol::ids::kControlRequest;
}

}  // namespace

std::span<const std::byte> SerialLink::read_waiting(core::TimePoint now) {
  std::size_t used = 0;
  while (used < waiting_.size()) {
    const core::Expected<std::size_t> count = uart_.read(std::span(waiting_).subspan(used));
    if (!count) {
      meter_.counters().outages += port_was_gone_ ? 0U : 1U;
      port_was_gone_ = true;
      break;
    }
    if (port_was_gone_) {
      port_was_gone_ = false;
      reset_autopilot();
    }
    if (*count == 0) {
      break;
    }
    if (tap_ != nullptr) {
      tap_->received(std::span(waiting_).subspan(used, *count), now);
    }
    used += *count;
  }
  meter_.received(used);
  return std::span(waiting_).first(used);
}

void SerialLink::reset_autopilot() {
  edges_ |= AuthorityCondition::kPortBack;
  answers_.reset();
  ever_received_ = false;
  seen_items_ = 0;
  clock_.reset();
  rc_item_is_real_ = false;
  sdk_version_ = 0;
  layout_ = protocol::TelemetryLayout::kM100;
  version_ = {};
}

void SerialLink::collect(core::TimePoint now) {
  behind_ = true;
  for (std::size_t batch = 0; behind_ && batch < kBatchesPerTick; ++batch) {
    const std::span<const std::byte> bytes = read_waiting(now);
    batch_end_ = parser_.stats().bytes + bytes.size();
    parser_.consume(bytes, [&](const protocol::FrameView& frame) { handle(frame, arrived(frame, now)); });
    reject_false_frames(now);
    behind_ = bytes.size() == waiting_.size();
  }
}

void SerialLink::reject_false_frames(core::TimePoint now) {
  while (candidates_.is_false(parser_, now, meter_.adapter_delay())) {
    parser_.abandon_candidate();
    for (auto frame = parser_.poll(); frame; frame = parser_.poll()) {
      handle(*frame, arrived(*frame, now));
    }
  }
}

core::TimePoint SerialLink::arrived(const protocol::FrameView& frame, core::TimePoint now) const {
  const std::uint64_t behind = batch_end_ - (frame.offset + frame.bytes.size());
  return std::max(last_step_, now - line_time(behind, config_.baud));
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
    ++meter_.counters().echoes;  // the autopilot never asks it
    says_something_new = false;
  } else {
    handle_push(*message);
  }
  last_frame_ = says_something_new ? now : last_frame_;
  ever_received_ = ever_received_ || says_something_new;
  dropped_bytes_ = parser_.stats().bytes_dropped;
}

bool SerialLink::handle_telemetry(const protocol::Message& message, core::TimePoint now) {
  const protocol::Telemetry former = telemetry_;
  protocol::FamilyItems more;
  const core::Status decoded = layout_ == protocol::TelemetryLayout::kFamily
                                   ? protocol::decode_family_telemetry(message.value, telemetry_, more)
                                   : protocol::decode_telemetry(message.value, telemetry_);
  if (decoded != core::Status::kOk) {
    ++meter_.counters().bad_packages;
    return true;
  }
  if (telemetry_.has(protocol::TelemetryItem::kTime) && !detect_restart(now)) {
    telemetry_ = former;
    ++meter_.counters().old_packages;
    return false;
  }
  meter_.counters().refused_items += reject_non_finite(telemetry_, former);
  meter_.package(now);
  for (std::size_t item = 0; item < item_times_.size(); ++item) {
    if (((std::uint32_t{telemetry_.items} >> item) & 1U) != 0) {
      item_times_[item] = now;
    }
  }
  update_mode_switch(now);
  seen_items_ = static_cast<std::uint16_t>(seen_items_ | telemetry_.items);
  telemetry_.items = static_cast<std::uint16_t>(telemetry_.items | former.items);
  return true;
}

void SerialLink::update_mode_switch(core::TimePoint now) {
  const bool ours_would_show = commanded_ && now - first_command_ >= kOwnModeShows;
  rc_item_is_real_ =
      rc_item_is_real_ || (telemetry_.has(protocol::TelemetryItem::kRc) && ours_would_show &&
                           telemetry_.control.virtual_rc_on() && telemetry_.rc.mode == protocol::kRcModeF);
}

bool SerialLink::detect_restart(core::TimePoint now) {
  // The package arrived between the last read and now. After our own stall this time is long, but it is no restart.
  const std::uint32_t ticks = telemetry_.time.ticks;
  const TelemetryClock::Verdict verdict = clock_.update(ticks, last_step_, now);
  if (verdict.restarted) {
    edges_ |= AuthorityCondition::kRestarted;
    meter_.restart();
  }
  // A package after dropped bytes may have waited for the parser to find it: its delay says nothing about the adapter.
  if (verdict.is_new && dropped_bytes_ == parser_.stats().bytes_dropped) {
    meter_.timed_package(now, static_cast<std::int64_t>(ticks) * TelemetryClock::kTick);
  }
  return verdict.is_new;
}

void SerialLink::handle_answer(const protocol::Message& message, core::TimePoint now) {
  const core::Expected<protocol::Answer> answer = sessions_.accept(message, now);
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
    sdk_version_ = protocol::sdk_version(*version).value_or(0);
    layout_ = protocol::telemetry_layout(*version);
    if (!protocol::is_decoded(layout_)) {
      authority_.answer = {.code = version->code,
                           .name = protocol::name(layout_),
                           .verdict = protocol::AckVerdict::kRefused,
                           .remedy = protocol::remedy(layout_)};
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
    (void)outbox_.add_answer(reception.bytes);
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
    outbox_.drop_command();
    if (message.header.session >= protocol::kFirstReliableSession) {
      const core::Expected<protocol::Outgoing> answer =
          answers_.answer(message.header, protocol::encode_ack(protocol::kAckSuccess), config_.cipher);
      if (answer) {
        (void)outbox_.add_answer(answer->bytes);
      }
    }
  }
}

}  // namespace m100::link
