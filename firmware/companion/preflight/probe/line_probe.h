// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "hal/uart.h"
#include "protocol/dji/frame_parser.h"
#include "protocol/dji/telemetry.h"
#include "protocol/mavlink/parser.h"

namespace m100::companion {

/// What is at the other end of a port, judged by listening alone.
enum class Verdict : std::uint8_t {
  kAutopilot,        ///< frames and telemetry: all is well
  kApiNotEnabled,    ///< frames, but no telemetry
  kWrongBaud,        ///< bytes, but no frame among them; many lack a stop bit, if the port counts that
  kNoAutopilot,      ///< bytes with good stop bits, but no frame among them
  kNoisy,            ///< frames, but many are damaged; or none, and some bytes without a stop bit
  kOverrun,          ///< frames, but many are damaged: this machine was too slow to take them
  kLineHeldLow,      ///< breaks, and no frame; few bytes or none besides
  kPosePort,         ///< MAVLink frames: the source of pose
  kNothingReceived,  ///< not one byte
  kCannotOpen,
};

std::string_view name(Verdict verdict);
/// Better verdicts have lower ranks: understood frames before mere bytes.
int rank(Verdict verdict);
std::string_view remedy(Verdict verdict);

/// The firmware whose layout of the telemetry fits the packages (protocol, section 8).
enum class Firmware : std::uint8_t { kUnknown, kM100, kM100Old, kOther };
std::string_view name(Firmware firmware);

/// Counts frames and telemetry in the bytes of a line, and judges them.
class LineProbe {
 public:
  void receive(std::span<const std::byte> bytes);

  /// @param errors that the port has counted meanwhile; without them the verdict uses the bytes alone.
  Verdict verdict(const core::Expected<hal::LineErrors>& errors = core::Status::kUnavailable) const;
  Firmware firmware() const;
  std::uint64_t packages() const { return packages_; }
  std::uint64_t bytes() const { return parser_.stats().bytes; }
  const protocol::ParserStats& stats() const { return parser_.stats(); }
  const protocol::Telemetry& telemetry() const { return telemetry_; }
  bool has_attitude_and_force() const {
    return telemetry_.has(protocol::TelemetryItem::kAttitude) && telemetry_.has(protocol::TelemetryItem::kAcceleration);
  }

 private:
  Verdict without_frames(const core::Expected<hal::LineErrors>& errors) const;
  void receive_telemetry(std::span<const std::byte> value);

  protocol::FrameParser parser_;
  mavlink::Parser mavlink_;
  protocol::CipherScratch scratch_{};
  protocol::Telemetry telemetry_;
  std::uint64_t packages_ = 0;
  std::uint64_t fit_m100_ = 0;
  std::uint64_t fit_old_ = 0;
};

}  // namespace m100::companion
