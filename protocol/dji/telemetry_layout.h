// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "firmware/core/expected.h"
#include "protocol/dji/acks.h"
#include "protocol/dji/telemetry.h"

namespace m100::protocol {

/// The telemetry layout of a flight controller. The package does not identify it; the version answer does.
enum class TelemetryLayout : std::uint8_t {
  kM100,    ///< M100 from firmware 3.0 on (telemetry.h)
  kFamily,  ///< A3, N3, M600 with firmware 3.1 or 3.2: two more items in the middle
  // Layouts that are known to be different and are not decoded.
  kOldM100,      ///< M100 before 3.0. In 2.3: a 600 Hz clock, no limit byte of the gimbal, no control mode
  kLaterFamily,  ///< A3, N3, M600 from firmware 3.3 on: other sizes of five items
  kUnknown,      ///< another controller, an A3, N3 or M600 before 3.1, or an unreadable text
};

/// Decides by the text of the version answer, "... HARDWARE-AA.BB.CC.DD".
TelemetryLayout telemetry_layout(const VersionAnswer& answer);

constexpr bool is_decoded(TelemetryLayout layout) {
  return layout == TelemetryLayout::kM100 || layout == TelemetryLayout::kFamily;
}
std::string_view name(TelemetryLayout layout);
/// The remedy as a sentence for the operator; empty if the layout is decoded.
std::string_view remedy(TelemetryLayout layout);

// An M100 never sends these two items of the family (protocol, section 8). In the family's flag word, the bits of the
// magnetometer and of all later items are therefore two places higher.

/// 32 bytes on the wire.
struct GpsDetail {
  std::uint32_t date = 0;
  std::uint32_t time = 0;
  std::int32_t longitude_1e7_deg = 0;
  std::int32_t latitude_1e7_deg = 0;
  std::int32_t height_mm = 0;
  std::array<float, 3> velocity_ned_cm_s{};
};
/// 44 bytes on the wire.
struct Rtk {
  std::uint32_t date = 0;
  std::uint32_t time = 0;
  double longitude_deg = 0.0;
  double latitude_deg = 0.0;
  float height_m = 0.F;
  std::array<float, 3> velocity{};  ///< unit and frame are not stated
  std::int16_t yaw = 0;
  std::uint8_t position_flag = 0;
  std::uint8_t yaw_flag = 0;
};
struct FamilyItems {
  bool has_gps_detail = false;  ///< of the last package
  bool has_rtk = false;
  GpsDetail gps_detail;
  Rtk rtk;
};

/// Decodes a package of the family. `telemetry.items` gets the M100's bits for what both have.
/// @returns kInvalidArgument: the size does not fit the flag word exactly; nothing is changed then.
core::Status decode_family_telemetry(std::span<const std::byte> value, Telemetry& telemetry, FamilyItems& more);

/// The place of each item in TelemetryFrequency::rates, by the number of the item on an M100.
std::array<std::uint8_t, 12> rate_places(TelemetryLayout layout);

}  // namespace m100::protocol
