// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <variant>

#include "firmware/core/expected.h"
#include "protocol/dji/commands.h"

namespace m100::protocol {

// Messages that the flight controller sends without a request, except telemetry (telemetry.h).

/// Control authority was lost: mode switch left F, the mobile app took over, ...
struct ControlLost {
  static constexpr std::uint8_t kValue = 0x04;
  std::uint8_t value = kValue;
};

struct FromMobile {
  MobileData data;
};

enum class MissionKind : std::uint8_t { kNone = 0, kWaypoint = 1, kHotPoint = 2, kFollow = 3, kIoc = 4 };

struct MissionStatus {
  std::uint8_t kind = 0;  ///< a MissionKind, if it is one
  std::array<std::uint8_t, 5> rest{};
};

struct WaypointEvent {
  std::uint8_t event = 0;  ///< 0 upload finished, 1 mission finished, 2 point reached
  std::array<std::uint8_t, 5> rest{};
};

using Push = std::variant<std::monostate, ControlLost, FromMobile, MissionStatus, WaypointEvent>;

constexpr MessageId id_of(const ControlLost&) { return ids::kControlLost; }
constexpr MessageId id_of(const FromMobile&) { return ids::kFromMobile; }
constexpr MessageId id_of(const MissionStatus&) { return ids::kMissionStatus; }
constexpr MessageId id_of(const WaypointEvent&) { return ids::kWaypointEvent; }

core::Expected<Value> encode(const ControlLost& push);
core::Expected<Value> encode(const FromMobile& push);
core::Expected<Value> encode(const MissionStatus& push);
core::Expected<Value> encode(const WaypointEvent& push);

/// @returns kInvalidArgument: not one of these, or its size is wrong.
core::Expected<Push> decode_push(MessageId id, std::span<const std::byte> value);

}  // namespace m100::protocol
