// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

#include "firmware/core/time.h"
#include "protocol/dji/frame_parser.h"
#include "protocol/dji/session.h"

namespace m100::link {

/// Statistics of a link for its user.
struct LinkHealth {
  /// Upper ends (exclusive) of the jitter bins [us]; the last bin has none.
  static constexpr std::array<std::int64_t, 9> kJitterBins_us{500, 1000, 2000, 4000, 8000, 16000, 32000, 64000, 128000};

  double telemetry_rate_hz = 0.0;  ///< packages in the last full second
  double receive_share = 0.0;      ///< of the line's capacity, last full second
  double send_share = 0.0;
  core::Duration telemetry_age{0};    ///< since the last package came; 0 before the first
  core::Duration longest_gap{0};      ///< between two packages, ever
  core::Duration transport_delay{0};  ///< of the last package beyond the fastest one, by the autopilot's clock
  /// Difference between the spacing of two packages at our end and by the autopilot's clock, counted by size.
  std::array<std::uint32_t, kJitterBins_us.size() + 1> jitter_histogram{};
  protocol::ParserStats parser;
  protocol::RequestStats sessions;
  std::uint64_t bytes_received = 0;
  std::uint64_t bytes_sent = 0;
  std::uint32_t packages = 0;          ///< of telemetry
  std::uint32_t bad_packages = 0;      ///< frames of any message, with a valid checksum, that cannot be decoded
  std::uint32_t old_packages = 0;      ///< repeated, overtaken, or the first of a new clock; not in `packages`
  std::uint32_t refused_items = 0;     ///< telemetry items that held a number that is not finite
  std::uint32_t undecipherable = 0;    ///< encrypted frames without a key for them, or not of whole blocks
  std::uint32_t commands_sent = 0;     ///< flight commands
  std::uint32_t commands_refused = 0;  ///< out of range, without control, or the last one is half sent
  std::uint32_t commands_dropped =
      0;                       ///< the line was too slow: replaced by a newer one, or void at a loss of authority
  std::uint32_t outages = 0;   ///< times the port was gone
  std::uint32_t restarts = 0;  ///< of the autopilot
  std::uint32_t echoes = 0;    ///< our own frames that came back
};

}  // namespace m100::link
