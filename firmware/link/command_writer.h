// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>

#include "firmware/core/time.h"
#include "firmware/link/byte_tap.h"
#include "firmware/link/link_config.h"
#include "firmware/link/link_meter.h"
#include "firmware/link/outbox.h"
#include "firmware/safety/authority.h"
#include "hal/uart.h"
#include "protocol/dji/acks.h"
#include "protocol/dji/session.h"
#include "protocol/dji/telemetry_layout.h"

namespace m100::link {

/// Turns requests, flight commands and answers into bytes of a UART. It holds the sessions, with their repeats, and the
/// queue of what has not left yet.
class CommandWriter {
 public:
  static constexpr std::uint8_t kEchoTransmissions = 8;  ///< 0.1 s apart: an answer that is 0.7 s late still counts

  /// @param tap may be null.
  CommandWriter(hal::Uart& uart, const LinkConfig& config, ByteTap* tap) : uart_(uart), tap_(tap), config_(config) {}

  /// Does what the authority table demands. @param version the autopilot's answer to the version query; empty: unknown.
  /// @returns kOk: queued, or nothing to do. kReleaseControl is always kOk: the table repeats a release that failed.
  core::Status perform(safety::AuthorityAction action, const protocol::VersionAnswer& version,
                       protocol::TelemetryLayout layout, bool virtual_rc_on, core::TimePoint now);
  /// The version query that only tests whether our bytes arrive.
  core::Status request_echo(core::TimePoint now);
  /// @returns kRefused: one is open already.
  core::Status request(const protocol::MotorRequest& request, core::TimePoint now);
  core::Status request(const protocol::TaskRequest& request, core::TimePoint now);
  /// Queues one flight command, which replaces one that still waits.
  /// @returns kResourceExhausted: the waiting one is half sent. Otherwise as the encoder: kOk, or why the command is
  ///   refused.
  core::Status write(const ChannelCommand& command);

  /// Queues the repeats that are due. @param failed called with each request that was repeated in vain.
  template <typename Failed>
  void poll(core::TimePoint now, Failed&& failed) {
    for (std::size_t i = 0; i < protocol::kReliableSessions; ++i) {
      const core::Expected<protocol::Due> due = sessions_.poll(now);
      if (!due) {
        return;
      }
      if (due->kind == protocol::Due::Kind::kRepeat) {
        (void)outbox_.add_request(due->frame.bytes);  // with a full outbox this repeat is lost: the next one follows
      } else {
        failed(due->command);
      }
    }
  }
  core::Expected<protocol::Answer> accept(const protocol::Message& message, core::TimePoint now) {
    return sessions_.accept(message, now);
  }
  bool is_open(protocol::MessageId id) const { return sessions_.is_open(id); }
  /// Cancels the requests that wait for their answer, and drops those that have not left yet.
  void cancel_requests();
  void write_answer(std::span<const std::byte> frame) { (void)outbox_.add_answer(frame); }
  bool has_command() const { return outbox_.has_command(); }
  void drop_command() { outbox_.drop_command(); }

  /// Writes what waits, as far as the UART takes it. @returns true: the last byte of a flight command left.
  bool flush(core::TimePoint now, LinkMeter& meter);
  const protocol::RequestStats& stats() const { return sessions_.stats(); }

 private:
  core::Status release(bool virtual_rc_on, core::TimePoint now);
  template <typename Command>
  core::Status request(const Command& command, std::uint8_t transmissions, core::TimePoint now);
  template <typename Command>
  core::Status transmit(const Command& command, bool is_control);

  hal::Uart& uart_;
  ByteTap* tap_;
  LinkConfig config_;
  protocol::RequestSessions sessions_;
  Outbox outbox_;
};

}  // namespace m100::link
