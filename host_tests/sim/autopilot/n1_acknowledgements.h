// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "firmware/core/time.h"
#include "host_tests/sim/autopilot/n1_event_log.h"
#include "host_tests/sim/autopilot/n1_line.h"
#include "host_tests/sim/autopilot/n1_script.h"
#include "protocol/cipher.h"
#include "protocol/dji/commands.h"
#include "protocol/dji/session.h"

namespace m100::sim {

/// The name in a script of the request that this command is.
N1Request request_of(const protocol::Command& command, protocol::MessageId id);

/// Answers in sessions: each is stored, so that no command is executed twice. A script can make acknowledgements be
/// lost, late or sent twice.
class N1Acknowledgements {
 public:
  /// @param own_delay from a command to its acknowledgement, to which a script adds
  N1Acknowledgements(const N1EventLog& log, N1Line& line, core::Duration own_delay)
      : log_(log), line_(line), own_delay_(own_delay) {}

  void lose(std::uint32_t count, N1Request of) {
    to_lose_ = count;
    to_lose_of_ = of;
  }
  void set_delay(core::Duration delay) { delay_ = delay; }
  void send_twice(std::uint32_t count) { to_double_ = count; }

  /// @returns whether the frame is new. A repeated one gets its stored answer again.
  bool accept(const protocol::FrameHeader& header);
  /// @param cipher null: a plain answer
  void answer(const protocol::FrameHeader& to, std::span<const std::byte> value, const protocol::Cipher* cipher,
              N1Request request);
  void restart() { sessions_.reset(); }

 private:
  void send(std::span<const std::byte> frame, N1Request request);
  bool loses(N1Request request);

  const N1EventLog& log_;
  N1Line& line_;
  protocol::AnswerSessions sessions_;
  /// The request that each session's stored answer belongs to.
  std::array<N1Request, protocol::kSessionCount> request_in_session_{};
  std::uint32_t to_lose_ = 0;
  N1Request to_lose_of_ = N1Request::kAny;
  std::uint32_t to_double_ = 0;
  core::Duration own_delay_;
  core::Duration delay_{0};
};

}  // namespace m100::sim
