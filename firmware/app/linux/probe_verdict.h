// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "protocol/frame_parser.h"
#include "protocol/telemetry.h"

namespace m100::app {

/// What is at the other end of a port, judged by listening alone.
enum class Verdict : std::uint8_t {
  kAutopilot,        ///< frames and telemetry: all is well
  kApiNotEnabled,    ///< frames, but no telemetry
  kWrongBaud,        ///< bytes, but no frame among them
  kNoisy,            ///< frames, but many are damaged
  kNothingReceived,  ///< not one byte
  kCannotOpen,
};

std::string_view name(Verdict verdict);
std::string_view remedy(Verdict verdict);

/// Whose layout of the telemetry the packages fit (protocol, section 8).
enum class Firmware : std::uint8_t { kUnknown, kM100, kM100Old, kOther };
std::string_view name(Firmware firmware);

/// Listens: bytes in, counts out.
class Listener {
 public:
  void take(std::span<const std::byte> bytes);

  Verdict verdict() const;
  Firmware firmware() const;
  std::uint64_t packages() const { return packages_; }
  std::uint64_t bytes() const { return parser_.stats().bytes; }
  const protocol::ParserStats& stats() const { return parser_.stats(); }
  const protocol::Telemetry& telemetry() const { return telemetry_; }

 private:
  void take_telemetry(std::span<const std::byte> value);

  protocol::FrameParser parser_;
  protocol::CipherScratch scratch_{};
  protocol::Telemetry telemetry_;
  std::uint64_t packages_ = 0;
  std::uint64_t fit_m100_ = 0;
  std::uint64_t fit_old_ = 0;
};

}  // namespace m100::app
