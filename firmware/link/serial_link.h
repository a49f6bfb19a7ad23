// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include "firmware/core/time.h"
#include "firmware/link/byte_tap.h"
#include "firmware/link/command_channel.h"
#include "firmware/link/command_writer.h"
#include "firmware/link/frame_receiver.h"
#include "firmware/link/link_config.h"
#include "firmware/link/link_health.h"
#include "firmware/link/link_meter.h"
#include "firmware/link/mode_switch.h"
#include "firmware/link/telemetry/telemetry_receiver.h"
#include "firmware/safety/authority.h"
#include "firmware/safety/link_status.h"
#include "hal/uart.h"
#include "protocol/dji/acks.h"
#include "protocol/dji/session.h"
#include "protocol/dji/telemetry.h"

namespace m100::link {

/// State of start-up and authority, with its reason.
struct AuthorityView {
  safety::AuthorityStage stage = safety::AuthorityStage::kListening;
  safety::AuthorityReason reason = safety::AuthorityReason::kStarting;
  protocol::AckMeaning answer;     ///< the autopilot's last, except to a release; the cause if reason is kAnswer
  bool in_control = false;         ///< commands may leave
  bool mode_f = false;             ///< as LinkStatus::mode_f
  bool control_requested = false;  ///< the operator's request is not served yet
  bool release_pending = false;    ///< control or Virtual RC may be ours
  bool port_gone = false;          ///< the device itself is gone: our bytes cannot leave
  bool link_alive = false;         ///< a frame other than old telemetry and echoes within the last 500 ms
  bool telemetry_fresh = false;    ///< a telemetry package within the last 100 ms
};

/// The autopilot at the other end of a UART: bytes to telemetry, and commands to bytes, by the authority table only.
///
/// One tick is receive(now), then at most one send(command, now). Nothing happens between two ticks. A command
/// that the line has not taken waits; a newer one replaces it, and a loss of control drops it.
///
/// Control that telemetry shows as ours while nobody wants it, or that may be ours while nothing is received, is given
/// back five times a second until telemetry shows that it is not ours (promise R15).
///
/// Cost per tick: FrameReceiver's. No heap.
class SerialLink {
 public:
  static constexpr std::size_t kBatchBytes = FrameReceiver::kBatchBytes;
  /// A tick that has not read all waiting bytes sends nothing, because its telemetry is stale.
  static constexpr std::size_t kBatchesPerTick = FrameReceiver::kBatchesPerTick;
  static constexpr core::Duration kLinkTimeout =
      std::chrono::milliseconds(500);  ///< for kLinkAlive and kItemsFresh of the authority table
  /// Precondition (asserted): the rate is inside the window of its channel; check it with command_period() first.
  SerialLink(hal::Uart& uart, const LinkConfig& config, ByteTap* tap = nullptr);

  /// Reads all bytes that have arrived, sends the required answers, and steps the authority table.
  /// @returns the newest telemetry; `items` are those that arrived since the last call.
  const protocol::Telemetry& receive(core::TimePoint now);

  /// Sends one flight command, if control is ours and the channel's rate allows one more.
  /// @returns kOk: it is on its way. kNotReady: too early for the rate of the channel, or received bytes are still
  ///   unread; nothing is sent. kRefused: not in control. kInvalidArgument: a command of the other channel.
  ///   kOutOfRange: a number is not finite or outside its range; nothing is sent.
  ///   kResourceExhausted: the line still holds bytes of the command before; nothing is sent.
  core::Status send(const ChannelCommand& command, core::TimePoint now);

  /// True if send() would not answer kNotReady or kRefused.
  bool due(core::TimePoint now) const { return authority_.in_control && !receiver_.is_behind() && limiter_.due(now); }

  /// The operator requests control: at most three requests, two seconds apart, then silence until the next call.
  void request_control(core::TimePoint now);
  /// The operator gives control back.
  void release(core::TimePoint now);

  /// Requests motors and tasks, in control only. The answer appears in authority().answer.
  /// @returns kRefused: not in control, or one is open already.
  core::Status request(const protocol::MotorRequest& request, core::TimePoint now);
  core::Status request(const protocol::TaskRequest& request, core::TimePoint now);
  /// Whether the last requested task still waits for its answer. Afterwards authority().answer is that answer until
  /// another one comes; its name is empty if none came.
  bool task_is_open() const { return writer_.is_open(protocol::ids::kTask); }

  const AuthorityView& authority() const { return authority_; }
  safety::LinkStatus status() const {
    return {.telemetry_age = meter_.health().telemetry_age,
            .in_control = authority_.in_control,
            .mode_f = authority_.mode_f};
  }
  const LinkHealth& health() const { return meter_.health(); }
  const protocol::Telemetry& telemetry() const { return telemetry_.telemetry(); }
  /// When the item last came; the epoch if never.
  core::TimePoint received_at(protocol::TelemetryItem item) const { return telemetry_.received_at(item); }
  /// The autopilot's description of itself; empty until it answered the version query.
  const protocol::VersionAnswer& version() const { return version_; }
  core::Duration command_period() const { return limiter_.period(); }

 private:
  void reset_autopilot();
  void handle(const protocol::FrameView& frame, core::TimePoint now);
  /// @returns false: the package is repeated, overtaken, or the first of a new clock.
  bool handle_telemetry(const protocol::Message& message, core::TimePoint now);
  void handle_answer(const protocol::Message& message, core::TimePoint now);
  void handle_push(const protocol::Message& message);
  safety::AuthorityCondition ack_condition(const protocol::Answer& answer);
  safety::AuthorityCondition level_conditions(core::TimePoint now) const;
  void check_uplink(core::TimePoint now);
  void step_authority(core::TimePoint now);
  void perform(safety::AuthorityAction action, core::TimePoint now);
  void flush(core::TimePoint now);

  LinkConfig config_;
  FrameReceiver receiver_;
  TelemetryReceiver telemetry_;
  ModeSwitch mode_switch_;
  CommandWriter writer_;
  protocol::AnswerSessions answers_;
  protocol::CipherScratch scratch_{};
  protocol::VersionAnswer version_;
  safety::AuthorityState state_;
  safety::AuthorityCondition edges_ = safety::AuthorityCondition::kNone;
  AuthorityView authority_;
  RateLimiter limiter_;
  LinkMeter meter_;
  core::TimePoint last_step_{};
  core::TimePoint last_frame_{};
  core::TimePoint last_echo_{};  ///< when the autopilot last answered any command
  bool ever_received_ = false;
};

}  // namespace m100::link
