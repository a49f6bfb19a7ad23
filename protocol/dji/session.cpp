// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/dji/session.h"

#include <algorithm>

#include "protocol/dji/frame_encoder.h"

namespace m100::protocol {

RequestOptions options_for(const MessageInfo& info, const Cipher* cipher) {
  return {.timeout = info.timeout, .transmissions = info.transmissions, .cipher = cipher};
}

core::Expected<Outgoing> RequestSessions::request(MessageId id, std::span<const std::byte> value,
                                                  const RequestOptions& options, core::TimePoint now) {
  std::uint8_t session = kFirstReliableSession;
  while (session < kPastReliableSessions && slot(session).open) {
    ++session;
  }
  if (session == kPastReliableSessions) {
    return core::Status::kResourceExhausted;
  }
  Slot& into = slot(session);
  std::uint16_t sequence = next_sequence_;
  if (into.used && sequence == into.sequence) {
    ++sequence;  // after 65536 frames: the other side would take it for the number that it has already answered
  }
  const Envelope envelope{.session = session, .encrypted = options.cipher != nullptr, .sequence = sequence};
  const auto bytes = encode_frame(envelope, &id, value, into.bytes, options.cipher);
  if (!bytes) {
    return bytes.status();
  }
  next_sequence_ = static_cast<std::uint16_t>(sequence + 1);
  into.open = true;
  into.used = true;
  into.id = id;
  into.sequence = sequence;
  into.sent = 1;
  into.transmissions = options.transmissions;
  into.timeout = std::max(options.timeout, kShortestTimeout);
  into.last_sent = now;
  into.size = static_cast<std::uint16_t>(bytes->size());
  ++stats_.requests;
  return Outgoing{.bytes = *bytes, .session = session, .sequence = sequence};
}

core::Expected<Outgoing> RequestSessions::send(MessageId id, std::span<const std::byte> value, const Cipher* cipher) {
  const Envelope envelope{.session = kUnansweredSession, .encrypted = cipher != nullptr, .sequence = next_sequence_};
  const auto bytes = encode_frame(envelope, &id, value, unanswered_, cipher);
  if (!bytes) {
    return bytes.status();
  }
  ++next_sequence_;
  return Outgoing{.bytes = *bytes, .session = kUnansweredSession, .sequence = envelope.sequence};
}

core::Expected<Answer> RequestSessions::accept(const Message& message, core::TimePoint now) {
  const FrameHeader& header = message.header;
  if (!header.is_ack) {
    return core::Status::kRefused;
  }
  if (header.session < kFirstReliableSession || header.session >= kPastReliableSessions || !slot(header.session).open ||
      slot(header.session).sequence != header.sequence) {
    ++stats_.stray_answers;
    return core::Status::kRefused;
  }
  Slot& answered = slot(header.session);
  answered.open = false;
  ++stats_.answers;
  return Answer{.command = answered.id,
                .session = header.session,
                .sequence = header.sequence,
                .transmissions = answered.sent,
                .round_trip = now - answered.last_sent,
                .value = message.value};
}

core::Expected<Due> RequestSessions::poll(core::TimePoint now) {
  for (std::uint8_t session = kFirstReliableSession; session < kPastReliableSessions; ++session) {
    Slot& late = slot(session);
    if (!late.open || now - late.last_sent <= late.timeout) {
      continue;
    }
    Due due{.kind = Due::Kind::kFailed,
            .command = late.id,
            .transmissions = late.sent,
            .frame = {.bytes = {}, .session = session, .sequence = late.sequence}};
    if (late.sent >= late.transmissions) {
      late.open = false;
      ++stats_.failures;
      return due;
    }
    ++late.sent;
    late.last_sent = now;
    ++stats_.repeats;
    due.kind = Due::Kind::kRepeat;
    due.transmissions = late.sent;
    due.frame.bytes = std::span<const std::byte>(late.bytes).first(late.size);
    return due;
  }
  return core::Status::kNotReady;
}

void RequestSessions::cancel(MessageId id) {
  for (Slot& candidate : slots_) {
    candidate.open = candidate.open && candidate.id != id;
  }
}

void RequestSessions::cancel_all() {
  for (Slot& each : slots_) {
    each.open = false;
  }
}

bool RequestSessions::is_open(MessageId id) const {
  return std::any_of(slots_.begin(), slots_.end(), [id](const Slot& each) { return each.open && each.id == id; });
}

std::size_t RequestSessions::open_count() const {
  return static_cast<std::size_t>(
      std::count_if(slots_.begin(), slots_.end(), [](const Slot& each) { return each.open; }));
}

AnswerSessions::Reception AnswerSessions::accept(const FrameHeader& header) {
  if (header.is_ack) {
    return {};
  }
  if (header.session < kFirstReliableSession) {
    ++stats_.executed;
    return {.verdict = Verdict::kExecute, .bytes = {}};
  }
  M100_ASSERT(header.session < kSessionCount);
  Slot& slot = slots_[header.session];
  if (!slot.used || slot.sequence != header.sequence) {
    slot.used = true;
    slot.sequence = header.sequence;
    slot.size = 0;
    ++stats_.executed;
    return {.verdict = Verdict::kExecute, .bytes = {}};
  }
  if (slot.size == 0) {
    ++stats_.unfinished;
    return {};
  }
  ++stats_.repeated;
  return {.verdict = Verdict::kRepeat, .bytes = std::span<const std::byte>(slot.bytes).first(slot.size)};
}

core::Expected<Outgoing> AnswerSessions::answer(const FrameHeader& to, std::span<const std::byte> value,
                                                const Cipher* cipher) {
  if (to.session == kUnansweredSession || to.session >= kSessionCount || to.is_ack) {
    return core::Status::kInvalidArgument;
  }
  Slot& slot = slots_[to.session];
  const bool stored = to.session >= kFirstReliableSession;
  if (stored && (!slot.used || slot.sequence != to.sequence)) {
    return core::Status::kRefused;
  }
  const Envelope envelope{
      .session = to.session, .is_ack = true, .encrypted = to.encrypted() && cipher != nullptr, .sequence = to.sequence};
  const auto bytes = encode_frame(envelope, nullptr, value, slot.bytes, cipher);
  if (!bytes) {
    return bytes.status();
  }
  slot.size = static_cast<std::uint16_t>(bytes->size());
  return Outgoing{.bytes = *bytes, .session = to.session, .sequence = to.sequence};
}

void AnswerSessions::reset() { slots_ = {}; }

}  // namespace m100::protocol
