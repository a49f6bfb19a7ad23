// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/dji/telemetry_layout.h"

#include <algorithm>

#include "protocol/bytes.h"

namespace m100::protocol {
namespace {

constexpr unsigned kFirstMovedItem = 6;  ///< the magnetometer, on the M100
constexpr unsigned kMoved = 2;
constexpr std::uint16_t kCommonItems = (1U << kFirstMovedItem) - 1U;
constexpr std::uint16_t kGpsDetailBit = 1U << 6U;
constexpr std::uint16_t kRtkBit = 1U << 7U;
constexpr std::size_t kGpsDetailBytes = 32;
constexpr std::size_t kRtkBytes = 44;

constexpr std::uint16_t m100_items(std::uint16_t family_items) {
  const unsigned moved = (static_cast<unsigned>(family_items) >> kMoved) & ~unsigned{kCommonItems};
  return static_cast<std::uint16_t>((family_items & kCommonItems) | (moved & kAllTelemetryItems));
}

GpsDetail take_gps_detail(ByteReader& reader) {
  GpsDetail detail;
  detail.date = reader.take<std::uint32_t>();
  detail.time = reader.take<std::uint32_t>();
  detail.longitude_1e7_deg = reader.take<std::int32_t>();
  detail.latitude_1e7_deg = reader.take<std::int32_t>();
  detail.height_mm = reader.take<std::int32_t>();
  reader.take(detail.velocity_ned_cm_s);
  return detail;
}

Rtk take_rtk(ByteReader& reader) {
  Rtk rtk;
  rtk.date = reader.take<std::uint32_t>();
  rtk.time = reader.take<std::uint32_t>();
  rtk.longitude_deg = reader.take<double>();
  rtk.latitude_deg = reader.take<double>();
  rtk.height_m = reader.take<float>();
  reader.take(rtk.velocity);
  rtk.yaw = reader.take<std::int16_t>();
  rtk.position_flag = reader.take<std::uint8_t>();
  rtk.yaw_flag = reader.take<std::uint8_t>();
  return rtk;
}

/// The word before the last dash.
std::string_view hardware(std::string_view version) {
  std::string_view word = version.substr(0, version.rfind('-'));
  const std::size_t space = word.rfind(' ');
  word.remove_prefix(space == std::string_view::npos ? 0 : space + 1);  // substr() would bring an exception
  return word;
}

}  // namespace

TelemetryLayout telemetry_layout(const VersionAnswer& answer) {
  const core::Expected<std::uint32_t> version = sdk_version(answer);
  if (!version) {
    return TelemetryLayout::kUnknown;
  }
  const std::string_view who = hardware(text(answer.version_name));
  const std::uint32_t major_minor = *version >> 16U;
  if (who == "M100") {
    return major_minor >= 0x0300U ? TelemetryLayout::kM100 : TelemetryLayout::kOldM100;
  }
  if (who == "A3" || who == "N3" || who.starts_with("M600")) {
    const bool is_stated = major_minor == 0x0301U || major_minor == 0x0302U;
    return is_stated                ? TelemetryLayout::kFamily
           : major_minor >= 0x0303U ? TelemetryLayout::kLaterFamily
                                    : TelemetryLayout::kUnknown;
  }
  return TelemetryLayout::kUnknown;
}

std::string_view name(TelemetryLayout layout) {
  constexpr std::array<std::string_view, 5> kNames{"m100", "family", "old_m100", "later_family", "unknown_controller"};
  return kNames[static_cast<std::size_t>(layout)];
}

std::string_view remedy(TelemetryLayout layout) {
  switch (layout) {
    case TelemetryLayout::kM100:
    case TelemetryLayout::kFamily:
      return "";
    case TelemetryLayout::kOldM100:
      return "an M100 with firmware 2.3 uses another telemetry layout: update the aircraft to 3.1 or later";
    case TelemetryLayout::kLaterFamily:
      return "the telemetry layout of an A3, N3 or M600 with firmware 3.3 or later is not supported";
    case TelemetryLayout::kUnknown:
      break;
  }
  return "unknown telemetry layout of this flight controller (known: M100 3.x; A3, N3, M600 3.1, 3.2)";
}

core::Status decode_family_telemetry(std::span<const std::byte> value, Telemetry& telemetry, FamilyItems& more) {
  constexpr std::size_t kFlag = sizeof(telemetry.items);
  if (value.size() < kFlag) {
    return core::Status::kInvalidArgument;
  }
  const auto flags = load<std::uint16_t>(value.data());
  const std::uint16_t items = m100_items(flags);
  const std::size_t before = telemetry_value_bytes(static_cast<std::uint16_t>(items & kCommonItems));
  const std::size_t gps_detail = (flags & kGpsDetailBit) != 0 ? kGpsDetailBytes : 0U;
  const std::size_t rtk = (flags & kRtkBit) != 0 ? kRtkBytes : 0U;
  if (value.size() != telemetry_value_bytes(items) + gps_detail + rtk) {
    return core::Status::kInvalidArgument;
  }
  // Rebuild the package of an M100: its own flag word, and no items between position and magnetometer.
  std::array<std::byte, telemetry_value_bytes(kAllTelemetryItems)> plain{};
  std::memcpy(plain.data(), &items, kFlag);
  std::copy(value.begin() + kFlag, value.begin() + static_cast<std::ptrdiff_t>(before), plain.begin() + kFlag);
  const std::span<const std::byte> after = value.subspan(before + gps_detail + rtk);
  std::copy(after.begin(), after.end(), plain.begin() + static_cast<std::ptrdiff_t>(before));
  const core::Status decoded = decode_telemetry(std::span(plain).first(before + after.size()), telemetry);
  if (decoded != core::Status::kOk) {
    return decoded;
  }
  ByteReader reader(value.subspan(before, gps_detail + rtk));
  more.has_gps_detail = gps_detail != 0;
  more.has_rtk = rtk != 0;
  more.gps_detail = more.has_gps_detail ? take_gps_detail(reader) : more.gps_detail;
  more.rtk = more.has_rtk ? take_rtk(reader) : more.rtk;
  return core::Status::kOk;
}

std::array<std::uint8_t, 12> rate_places(TelemetryLayout layout) {
  std::array<std::uint8_t, 12> places{};
  for (std::size_t item = 0; item < places.size(); ++item) {
    const bool moves = layout == TelemetryLayout::kFamily && item >= kFirstMovedItem;
    places[item] = static_cast<std::uint8_t>(moves ? item + kMoved : item);
  }
  return places;
}

}  // namespace m100::protocol
