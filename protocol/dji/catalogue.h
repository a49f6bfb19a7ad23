// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <string_view>

#include "firmware/core/time.h"
#include "protocol/dji/frame.h"

namespace m100::protocol {

namespace ids {
inline constexpr MessageId kVersionQuery{0x00, 0x00};
inline constexpr MessageId kActivation{0x00, 0x01};
inline constexpr MessageId kTelemetryFrequency{0x00, 0x10};
inline constexpr MessageId kToMobile{0x00, 0xFE};
inline constexpr MessageId kControlRequest{0x01, 0x00};
inline constexpr MessageId kTask{0x01, 0x01};
inline constexpr MessageId kTaskQuery{0x01, 0x02};
inline constexpr MessageId kMovement{0x01, 0x03};
inline constexpr MessageId kMotors{0x01, 0x05};
inline constexpr MessageId kGimbalRate{0x01, 0x1A};
inline constexpr MessageId kGimbalAngle{0x01, 0x1B};
inline constexpr MessageId kPhoto{0x01, 0x20};
inline constexpr MessageId kVideoStart{0x01, 0x21};
inline constexpr MessageId kVideoStop{0x01, 0x22};
inline constexpr MessageId kTelemetry{0x02, 0x00};
inline constexpr MessageId kControlLost{0x02, 0x01};
inline constexpr MessageId kFromMobile{0x02, 0x02};
inline constexpr MessageId kMissionStatus{0x02, 0x03};
inline constexpr MessageId kWaypointEvent{0x02, 0x04};
inline constexpr MessageId kSyncPulse{0x04, 0x00};
inline constexpr MessageId kVirtualRcSwitch{0x05, 0x00};
inline constexpr MessageId kVirtualRcData{0x05, 0x01};
}  // namespace ids

enum class Direction : std::uint8_t { kToController, kFromController };

/// How a message is transmitted.
enum class Delivery : std::uint8_t {
  kUnanswered,  ///< session 0: sent once, no acknowledgement
  kReliable,    ///< sessions 2..31: the identical bytes are sent again until acknowledged, within `transmissions`
};

/// The fixed properties of a message.
struct MessageInfo {
  MessageId id;
  std::string_view name;  ///< as it appears in logs and in `m100-lab frames`
  Direction direction = Direction::kToController;
  std::uint8_t min_value_bytes = 0;
  std::uint8_t max_value_bytes = 0;
  Delivery delivery = Delivery::kUnanswered;
  core::Duration timeout{};        ///< before the bytes are sent again
  std::uint8_t transmissions = 1;  ///< at most, the first one included
};

/// Every message of the protocol except the ground-station missions (set 0x03). Time-outs and numbers of transmissions
/// are those of DJI's SDK where it states useful ones; the frequency command, which the SDK sends once and loses, and
/// arming are sent up to three times.
inline constexpr std::array kCatalogue = [] {
  using std::chrono::milliseconds;
  constexpr auto kTo = Direction::kToController;
  constexpr auto kFrom = Direction::kFromController;
  constexpr auto kOnce = Delivery::kUnanswered;
  constexpr auto kSure = Delivery::kReliable;
  return std::array{
      MessageInfo{ids::kVersionQuery, "version_query", kTo, 1, 1, kSure, milliseconds(100), 3},
      MessageInfo{ids::kActivation, "activate", kTo, 44, 44, kSure, milliseconds(1000), 3},
      MessageInfo{ids::kTelemetryFrequency, "set_broadcast_frequency", kTo, 16, 16, kSure, milliseconds(100), 3},
      MessageInfo{ids::kToMobile, "to_mobile", kTo, 0, 100, kSure, milliseconds(500), 2},
      MessageInfo{ids::kControlRequest, "control", kTo, 1, 1, kSure, milliseconds(500), 2},
      MessageInfo{ids::kTask, "task", kTo, 2, 2, kSure, milliseconds(100), 3},
      MessageInfo{ids::kTaskQuery, "task_query", kTo, 1, 1, kSure, milliseconds(100), 3},
      MessageInfo{ids::kMovement, "movement", kTo, 17, 17, kOnce, {}, 1},
      MessageInfo{ids::kMotors, "motors", kTo, 1, 1, kSure, milliseconds(100), 3},
      MessageInfo{ids::kGimbalRate, "gimbal_rate", kTo, 7, 7, kOnce, {}, 1},
      MessageInfo{ids::kGimbalAngle, "gimbal_angle", kTo, 8, 8, kOnce, {}, 1},
      MessageInfo{ids::kPhoto, "photo", kTo, 1, 1, kOnce, {}, 1},
      MessageInfo{ids::kVideoStart, "video_start", kTo, 1, 1, kOnce, {}, 1},
      MessageInfo{ids::kVideoStop, "video_stop", kTo, 1, 1, kOnce, {}, 1},
      MessageInfo{ids::kTelemetry, "telemetry", kFrom, 2, 124, kOnce, {}, 1},
      MessageInfo{ids::kControlLost, "lost_control", kFrom, 1, 1, kOnce, {}, 1},
      MessageInfo{ids::kFromMobile, "from_mobile", kFrom, 1, 100, kOnce, {}, 1},
      MessageInfo{ids::kMissionStatus, "mission_status", kFrom, 6, 6, kOnce, {}, 1},
      MessageInfo{ids::kWaypointEvent, "waypoint_event", kFrom, 6, 6, kOnce, {}, 1},
      MessageInfo{ids::kSyncPulse, "sync_frequency", kTo, 4, 6, kOnce, {}, 1},
      MessageInfo{ids::kVirtualRcSwitch, "vrc_switch", kTo, 1, 64, kOnce, {}, 1},
      MessageInfo{ids::kVirtualRcData, "vrc_data", kTo, 64, 64, kOnce, {}, 1},
  };
}();

/// @returns null for a message that is not in the catalogue.
constexpr const MessageInfo* find(MessageId id) {
  for (const MessageInfo& info : kCatalogue) {
    if (info.id == id) {
      return &info;
    }
  }
  return nullptr;
}

constexpr std::string_view name(MessageId id) {
  const MessageInfo* const info = find(id);
  return info != nullptr ? info->name : std::string_view("unknown");
}

}  // namespace m100::protocol
