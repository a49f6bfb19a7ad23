// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/core/time.h"
#include "firmware/link/byte_tap.h"
#include "firmware/link/command_channel.h"
#include "firmware/link/false_header_detector.h"
#include "firmware/link/link_health.h"
#include "firmware/link/link_meter.h"
#include "firmware/link/outbox.h"
#include "firmware/link/telemetry_clock.h"
#include "firmware/safety/authority.h"
#include "hal/uart.h"
#include "protocol/cipher.h"
#include "protocol/dji/acks.h"
#include "protocol/dji/frame_parser.h"
#include "protocol/dji/session.h"
#include "protocol/dji/telemetry.h"
#include "protocol/dji/telemetry_layout.h"

namespace m100::link {

struct LinkConfig {
  ChannelConfig channel;
  std::uint32_t app_id = 0;                  ///< from DJI's developer site
  const protocol::Cipher* cipher = nullptr;  ///< the key of that app; null: nothing is encrypted or decrypted
  bool encrypt_commands = false;             ///< sets 0x01 and 0x05; answers are taken either way
  std::uint32_t baud = 230400;               ///< for the shares in LinkHealth only
  /// Rate of each telemetry item. RC and control at 100 Hz, because they show a loss of control.
  std::array<protocol::Rate, 16> rates{protocol::Rate::k100Hz, protocol::Rate::k100Hz, protocol::Rate::k100Hz,
                                       protocol::Rate::k100Hz, protocol::Rate::k100Hz, protocol::Rate::k10Hz,
                                       protocol::Rate::kOff,   protocol::Rate::k100Hz, protocol::Rate::kOff,
                                       protocol::Rate::k10Hz,  protocol::Rate::k1Hz,   protocol::Rate::k100Hz};
};

/// State of start-up and authority, with its reason.
struct AuthorityView {
  safety::AuthorityStage stage = safety::AuthorityStage::kListening;
  safety::AuthorityReason reason = safety::AuthorityReason::kStarting;
  protocol::AckMeaning answer;  ///< of the autopilot to the last command; says more if reason is kAnswer
  bool in_control = false;      ///< commands may leave
  bool mode_f = false;
  bool control_requested = false;  ///< the operator's ask is not served yet
  bool release_pending = false;    ///< control or Virtual RC may be ours; false: telemetry shows the transmitter
  bool port_gone = false;          ///< the device itself is gone: our bytes cannot leave
  bool link_alive = false;         ///< a frame within the last 500 ms
  bool telemetry_fresh = false;    ///< a telemetry package within the last 100 ms
};

/// The autopilot at the other end of a UART: bytes to telemetry, and commands to bytes, by the authority table only.
///
/// One tick is receive(now), then at most one send(command, now). Nothing happens between two ticks, so every command
/// that leaves was computed in this tick; a command that could not leave is dropped, not kept.
///
/// A message is dated by the line time of the bytes that follow it in the same read, not by the time of the read.
///
/// Control that telemetry shows as ours while nobody wants it, or that may be ours while nothing is heard, is given
/// back five times a second until telemetry shows the transmitter (promise R15); authority().release_pending is true
/// meanwhile.
///
/// Cost per tick: the bytes that came through the parser, at most kBatchesPerTick batches. No heap.
class SerialLink {
 public:
#ifdef M100_SMALL_MEMORY
  static constexpr std::size_t kBatchBytes = 512;  ///< size of the interrupt's ring
#else
  static constexpr std::size_t kBatchBytes = 65536;  ///< a driver may hold as much after a stall
#endif
  /// A tick that has not read all waiting bytes sends nothing, because its telemetry is stale.
  static constexpr std::size_t kBatchesPerTick = 16;
  static constexpr core::Duration kLinkTimeout =
      std::chrono::milliseconds(500);  ///< promise sheet: link silent, RELEASE
  /// If the RC item shows mode F this long after Virtual RC data (of mode A) began, it shows the real switch.
  static constexpr core::Duration kOwnModeShows = std::chrono::milliseconds(200);
  /// Two calls of receive() that are further apart mean that our own program stalled: control goes back.
  static constexpr core::Duration kOwnStall = std::chrono::milliseconds(500);
  /// In control the version query is sent this long after the autopilot's last answer. Telemetry shows us in control
  /// whether our bytes arrive or not; only an answer proves that they arrive. With the retries it takes at most a
  /// second until the operator is told that they do not.
  static constexpr core::Duration kEchoSpacing = std::chrono::milliseconds(200);
  static constexpr std::uint8_t kEchoTransmissions = 8;  ///< 0.1 s apart: an answer that is 0.7 s late still counts
  static constexpr core::Duration kFreshFor = std::chrono::milliseconds(100);  ///< its data are stale

  /// Precondition (asserted): the rate is inside the window of its channel; check it with command_period() first.
  SerialLink(hal::Uart& uart, const LinkConfig& config, ByteTap* tap = nullptr);

  /// Reads all bytes that have arrived, sends the required answers, and steps the authority table.
  /// @returns the newest telemetry; `items` are those that arrived since the last call.
  const protocol::Telemetry& receive(core::TimePoint now);

  /// Sends one flight command, if control is ours and the channel's rate allows one more.
  /// @returns kOk: it is on its way. kNotReady: too early for the rate of the channel, or not all bytes are read;
  ///   nothing left. kRefused: not in control. kInvalidArgument: a command of the other channel.
  ///   kOutOfRange: a number is not finite or outside its range; nothing left.
  ///   kResourceExhausted: the line still holds bytes of the command before; nothing left.
  core::Status send(const ChannelCommand& command, core::TimePoint now);

  /// True if send() would not answer kNotReady or kRefused.
  bool due(core::TimePoint now) const { return authority_.in_control && !behind_ && limiter_.due(now); }

  /// The operator asks for control: at most three requests, two seconds apart, then silence until the next call.
  void request_control(core::TimePoint now);
  /// The operator gives control back.
  void release(core::TimePoint now);

  /// Requests motors and tasks, in control only. The answer appears in authority().answer.
  /// @returns kRefused: not in control, or one is open already.
  core::Status request(const protocol::MotorRequest& request, core::TimePoint now);
  core::Status request(const protocol::TaskRequest& request, core::TimePoint now);
  /// The last requested task still waits for its answer. Afterwards authority().answer is that answer, without a name
  /// if none came.
  bool task_is_open() const { return sessions_.is_open(protocol::ids::kTask); }

  const AuthorityView& authority() const { return authority_; }
  const LinkHealth& health() const { return meter_.health(); }
  const protocol::Telemetry& telemetry() const { return telemetry_; }
  /// When the item last came; the epoch if never.
  core::TimePoint received_at(protocol::TelemetryItem item) const;
  /// The autopilot's description of itself; empty until it answered the version query.
  const protocol::VersionAnswer& version() const { return version_; }
  core::Duration command_period() const { return limiter_.period(); }

 private:
  void reset_autopilot();
  void collect(core::TimePoint now);
  std::span<const std::byte> read_waiting(core::TimePoint now);
  void reject_false_frames(core::TimePoint now);
  core::TimePoint arrived(const protocol::FrameView& frame, core::TimePoint now) const;
  void handle(const protocol::FrameView& frame, core::TimePoint now);
  /// @returns false: repeated or overtaken telemetry.
  bool handle_telemetry(const protocol::Message& message, core::TimePoint now);
  void handle_answer(const protocol::Message& message, core::TimePoint now);
  void handle_push(const protocol::Message& message);
  bool detect_restart(core::TimePoint now);
  void update_mode_switch(core::TimePoint now);
  safety::AuthorityCondition ack_condition(const protocol::Answer& answer);
  safety::AuthorityCondition level_conditions(core::TimePoint now) const;
  void poll_sessions(core::TimePoint now);
  void check_uplink(core::TimePoint now);
  void step_authority(core::TimePoint now);
  void act(safety::AuthorityAction action, core::TimePoint now);
  void cancel_open_request();
  template <typename Command>
  core::Status send_request(const Command& command, std::uint8_t transmissions, core::TimePoint now);
  template <typename Command>
  core::Status transmit(const Command& command, bool is_control);
  core::Status send_release(core::TimePoint now);
  void flush(core::TimePoint now);
  bool recent(protocol::TelemetryItem item, core::TimePoint now, core::Duration age) const;

  hal::Uart& uart_;
  LinkConfig config_;
  ByteTap* tap_;
  protocol::FrameParser parser_;
  FalseHeaderDetector candidates_;
  std::array<std::byte, kBatchBytes> waiting_{};
  std::uint64_t batch_end_ = 0;      ///< position in the stream after the last read
  std::uint64_t dropped_bytes_ = 0;  ///< by the parser, when the frame before was found
  bool behind_ = false;              ///< more waits than a tick takes
  protocol::CipherScratch scratch_{};
  protocol::RequestSessions sessions_;
  protocol::AnswerSessions answers_;
  protocol::Telemetry telemetry_;
  protocol::VersionAnswer version_;
  std::uint32_t sdk_version_ = 0;
  protocol::TelemetryLayout layout_ = protocol::TelemetryLayout::kM100;
  std::array<core::TimePoint, protocol::kTelemetryItemCount> item_times_{};
  std::uint16_t seen_items_ = 0;
  safety::AuthorityState state_;
  safety::AuthorityCondition edges_ = safety::AuthorityCondition::kNone;
  AuthorityView authority_;
  RateLimiter limiter_;
  Outbox outbox_;
  LinkMeter meter_;
  core::TimePoint last_step_{};
  core::TimePoint last_frame_{};
  core::TimePoint last_echo_{};  ///< the autopilot last answered anything
  bool ever_received_ = false;
  bool commanded_ = false;  ///< since control was granted
  core::TimePoint first_command_{};
  bool rc_item_is_real_ = false;  ///< it shows the transmitter even while Virtual RC is on
  bool port_was_gone_ = false;
  TelemetryClock clock_;
};

}  // namespace m100::link
