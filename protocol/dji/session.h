// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/core/assert.h"
#include "firmware/core/expected.h"
#include "firmware/core/time.h"
#include "protocol/cipher.h"
#include "protocol/dji/catalogue.h"
#include "protocol/dji/frame.h"

namespace m100::protocol {

// Sessions 2..31 are reliable: the requesting side repeats the identical bytes until it is answered or gives up; the
// answering side executes a sequence number once and repeats its stored answer. Session 0 is never answered; session 1
// is sent once, and answers to it are ignored; no command of DJI's SDK uses it, and none of ours. Both ends of the wire
// may play both parts: an onboard computer requests, and answers the control-lost push; a flight controller answers,
// and may push in a session.

inline constexpr std::uint8_t kUnansweredSession = 0;
inline constexpr std::uint8_t kFirstReliableSession = 2;
#ifdef M100_SMALL_MEMORY
inline constexpr std::size_t kReliableSessions = 6;  ///< requests that may be open at a time
#else
inline constexpr std::size_t kReliableSessions = kSessionCount - kFirstReliableSession;
#endif
inline constexpr std::uint8_t kPastReliableSessions = kFirstReliableSession + kReliableSessions;
/// Shortest time-out; a shorter one counts as this (DJI's SDK waits as long).
inline constexpr core::Duration kShortestTimeout = std::chrono::milliseconds(20);

/// A frame to be written to the line, and the numbers that identify its answer.
struct Outgoing {
  std::span<const std::byte> bytes;  ///< valid until the next call of the object that made it
  std::uint8_t session = 0;
  std::uint16_t sequence = 0;
};

struct RequestOptions {
  core::Duration timeout{};        ///< before the bytes are sent again; at least kShortestTimeout counts
  std::uint8_t transmissions = 1;  ///< at most, the first one included; 0 counts as 1 (no request repeats for ever)
  const Cipher* cipher = nullptr;  ///< the frame is encrypted with it if there is one
};

/// The options that the catalogue states for a message; it is encrypted if there is a cipher.
RequestOptions options_for(const MessageInfo& info, const Cipher* cipher = nullptr);

/// An answer that belongs to an open request.
struct Answer {
  MessageId command;
  std::uint8_t session = 0;
  std::uint16_t sequence = 0;
  std::uint8_t transmissions = 0;    ///< until the answer
  core::Duration round_trip{};       ///< since the last transmission
  std::span<const std::byte> value;  ///< of the message passed to accept()
};

/// A repetition or a failure that poll() found due.
struct Due {
  enum class Kind : std::uint8_t { kRepeat, kFailed };
  Kind kind = Kind::kRepeat;
  MessageId command;
  std::uint8_t transmissions = 0;  ///< so far, this one included
  Outgoing frame;                  ///< bytes to send again; empty after kFailed
};

struct RequestStats {
  std::uint32_t requests = 0;
  std::uint32_t repeats = 0;
  std::uint32_t answers = 0;
  std::uint32_t failures = 0;       ///< all transmissions used, no answer
  std::uint32_t stray_answers = 0;  ///< duplicated, late, or without a request
};

/// The requesting side. Fixed capacity: kReliableSessions requests open at a time. Time is an argument.
class RequestSessions {
 public:
  /// Longest frame that can be repeated: 100 bytes to the mobile app, encrypted, are 128.
  static constexpr std::size_t kFrameBytes = 144;

  explicit RequestSessions(std::uint16_t first_sequence = 0) : next_sequence_(first_sequence) {}

  /// Opens the lowest free session. The caller writes the bytes now; poll() repeats them.
  /// @returns kResourceExhausted: all sessions are open, or the frame is too long to store. Other codes: encode_frame.
  core::Expected<Outgoing> request(MessageId id, std::span<const std::byte> value, const RequestOptions& options,
                                   core::TimePoint now);

  /// Session 0: no answer, nothing is stored.
  core::Expected<Outgoing> send(MessageId id, std::span<const std::byte> value, const Cipher* cipher = nullptr);

  /// Takes an acknowledgement; its session is free afterwards.
  /// @returns kRefused: not an acknowledgement, or it answers no open request (duplicated, late, session 0 or 1).
  core::Expected<Answer> accept(const Message& message, core::TimePoint now);

  /// One repetition or one failure that is due; call until kNotReady. A failed request is closed and reported once.
  core::Expected<Due> poll(core::TimePoint now);

  /// Drops the open requests of this message without a report: a command that is no longer valid must not be repeated.
  void cancel(MessageId id);
  /// Drops every open request without a report.
  void cancel_all();

  bool is_open(MessageId id) const;
  std::size_t open_count() const;
  const RequestStats& stats() const { return stats_; }

 private:
  struct Slot {
    bool open = false;
    bool used = false;  ///< `sequence` was sent in this session before
    MessageId id;
    std::uint16_t sequence = 0;
    std::uint8_t sent = 0;
    std::uint8_t transmissions = 1;
    core::Duration timeout{};
    core::TimePoint last_sent{};
    std::uint16_t size = 0;
    std::array<std::byte, kFrameBytes> bytes{};
  };

  Slot& slot(std::uint8_t session) {
    M100_ASSERT(session >= kFirstReliableSession && session < kPastReliableSessions);
    return slots_[session - kFirstReliableSession];
  }

  std::array<Slot, kReliableSessions> slots_{};
  std::array<std::byte, kMaxFrameBytes> unanswered_{};
  std::uint16_t next_sequence_;
  RequestStats stats_;
};

struct AnswerStats {
  std::uint32_t executed = 0;
  std::uint32_t repeated = 0;    ///< stored answers sent again
  std::uint32_t unfinished = 0;  ///< repeated before the first answer was given
};

/// The answering side: stores the last sequence number of each reliable session and its answer. Fixed capacity.
class AnswerSessions {
 public:
  /// Longest answer: VersionAnswer, encrypted, is 80 bytes.
  static constexpr std::size_t kFrameBytes = 96;

  enum class Verdict : std::uint8_t {
    kExecute,  ///< new, as all in sessions 0 and 1: handle it, then answer() if its session is not 0
    kRepeat,   ///< executed before: send `bytes` again, do nothing else
    kIgnore,   ///< an acknowledgement, or executed before and not answered yet
  };
  struct Reception {
    Verdict verdict = Verdict::kIgnore;
    std::span<const std::byte> bytes;
  };

  /// Decides by the header alone what to do with a command or push, so the data need not be decipherable.
  Reception accept(const FrameHeader& header);

  /// Makes the acknowledgement of a command for which accept() returned kExecute, and stores it (sessions 2..31).
  /// @param cipher encrypts the answer if the command was encrypted; null answers plain.
  /// @returns kInvalidArgument: session 0, which is never answered, a session above 31, or an acknowledgement.
  ///   kRefused: accept() did not get this sequence number last. kResourceExhausted: too long to store.
  core::Expected<Outgoing> answer(const FrameHeader& to, std::span<const std::byte> value,
                                  const Cipher* cipher = nullptr);

  /// Forgets all sessions, but not the counters: the device has restarted.
  void reset();
  const AnswerStats& stats() const { return stats_; }

 private:
  struct Slot {
    bool used = false;
    std::uint16_t sequence = 0;
    std::uint16_t size = 0;  ///< 0: not answered yet
    std::array<std::byte, kFrameBytes> bytes{};
  };
  std::array<Slot, kSessionCount> slots_{};
  AnswerStats stats_;
};

}  // namespace m100::protocol
