// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <ostream>
#include <string>

#include "firmware/companion/files/file_use.h"
#include "firmware/companion/files/pose_options.h"
#include "firmware/companion/files/signature_times_file.h"
#include "firmware/companion/files/text/json.h"
#include "firmware/companion/ground_station/mavlink_tap.h"
#include "firmware/link/pose/pose_link.h"
#include "firmware/link/pose/signed_line.h"
#include "hal/linux/serial_port.h"
#include "hal/linux/udp_port.h"
#include "protocol/dji/frame_parser.h"

namespace m100::companion {

/// Refuses options that conflict_of() names, a simulated port beside a real one, and the autopilot's port. @param
/// autopilot name of that port. Errors: UsageError, FileError.
void check(const PoseOptions& options, const std::string& autopilot);

/// The files that the two ports use: a key is read, and the file of its accepted signatures beside it is written. The
/// caller adds the other files of its command. @param autopilot name of the autopilot's port
FileUse files_of(const PoseOptions& options, const std::string& autopilot);

/// Lets a UDP port answer the program that sent the newest frame of the chosen sender.
class ReplyToSender final : public MavlinkTap {
 public:
  ReplyToSender(hal::UdpPort& port, link::SenderChoice choice) : MavlinkTap(port), port_(port), choice_(choice) {}

 private:
  void receive(const mavlink::FrameView& frame) override {
    if (choice_.admits(frame.from)) {
      port_.answer_last();
    }
  }
  hal::UdpPort& port_;
  link::SenderChoice choice_;
};

/// The port of the pose: a serial line or a network. With a key, only frames that are signed and new pass; without one
/// a network is the loopback alone, see check().
class PosePort {
 public:
  /// Opens the port. @param options accepted by check(). @param clock_port for hal::PortClock. Errors: UsageError.
  PosePort(const PoseOptions& options, const std::string& clock_port);
  ~PosePort();
  PosePort(const PosePort&) = delete;
  PosePort& operator=(const PosePort&) = delete;

  /// Call it before the reads of a tick: renews the number of signatures that the tick may verify, and hands the newest
  /// time stamps to the file that outlives the program.
  void tick();
  /// SerialPort::mark_arrived(), or that of the network.
  void mark_arrived() { udp_ ? udp_->mark_arrived() : serial_->mark_arrived(); }
  hal::Uart& line() { return *line_; }
  /// For what is sent to the ground station; null: the port is a serial line.
  const hal::UdpPort* network() const { return udp_ ? &*udp_ : nullptr; }
  std::optional<mavlink::Key> key() const { return signed_ ? std::optional(key_) : std::nullopt; }
  /// Least time stamp of the signatures of what is sent now.
  mavlink::SignatureTime min_time() const { return signed_ ? signed_->min_time() : mavlink::SignatureTime{0}; }
  /// The baud rate, which gives the transmission time of a byte; 0: a network.
  std::uint32_t baud() const { return udp_ ? 0 : options_.baud; }
  const std::string& name() const { return options_.port; }
  const std::string& clock_port() const { return clock_port_; }
  /// Whether goals and orders may come: signed, or over the loopback.
  bool has_ground_station() const { return signed_ || udp_; }
  /// Null: without a key.
  const link::SignedLineStats* signatures() const { return signed_ ? &signed_->stats() : nullptr; }

 private:
  PoseOptions options_;
  std::string clock_port_;
  hal::PortClock clock_;
  mavlink::SignatureTime start_;  ///< signature time at which clock_ shows zero
  std::optional<hal::SerialPort> serial_;
  std::optional<hal::UdpPort> udp_;
  std::optional<ReplyToSender> reply_to_sender_;
  std::unique_ptr<SignatureTimesFile> replay_file_;
  mavlink::Key key_{};
  std::optional<link::SignedLine> signed_;
  hal::Uart* line_ = nullptr;
  std::uint32_t ticks_ = 0;
};

/// Sees frames of the autopilot's protocol in the bytes of the pose port: there are some if the ports are exchanged.
class ExchangedPorts final : public link::ByteTap {
 public:
  void received(std::span<const std::byte> bytes, core::TimePoint now) override;
  void sent(std::span<const std::byte> /*bytes*/, core::TimePoint /*now*/) override {}
  bool seen() const { return frames_ > 0; }

 private:
  protocol::FrameParser parser_;
  std::uint32_t frames_ = 0;
};
/// Why no pose came: a sentence about what came instead.
std::string why_no_pose(const link::PoseLink& link, const PosePort& port, const ExchangedPorts& exchanged);
/// "system 1 component 197 (100 poses a second) and system 2 component 197 (50 poses a second)".
std::string describe(const link::PoseSenders& senders);
/// The refused poses by their reasons, in sentences; empty: none was refused.
std::string describe_refusals(const link::PoseLinkStats& poses);
/// "0 frames signed with the key; refused: 12 unsigned, 3 with a wrong signature, ...".
std::string describe(const link::SignedLineStats& signatures);
Json to_json(const link::SignedLineStats& signatures);
/// {"used", "refused": {reason: count}, "senders": [[system, component, count]]}.
Json pose_json(const link::PoseLink& link);
/// The counts of poses and signatures. @param signatures may be null.
Json to_json(const link::PoseLinkStats& poses, const link::SignedLineStats* signatures);
void print(std::ostream& out, const link::PoseLinkStats& poses, const link::SignedLineStats* signatures);

}  // namespace m100::companion
