// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <variant>

#include "firmware/core/expected.h"
#include "protocol/dji/catalogue.h"
#include "protocol/dji/value.h"

namespace m100::protocol {

// All commands of the onboard computer to the flight controller, with units and ranges of DJI's documents. encode()
// refuses (kOutOfRange) any number that is not finite or outside its range, so none can reach the wire.

struct VersionQuery {
  std::uint8_t arbitrary = 0;
};

struct Activation {
  static constexpr std::size_t kBundleBytes = 32;
  std::uint32_t app_id = 0;
  std::uint32_t api_level = 2;  ///< reserved in firmware 3.1; DJI's SDK always sends 2
  std::uint32_t version = 0;    ///< 0xAABBCCDD for A.B.C.D, see sdk_version() in acks.h
  std::array<char, kBundleBytes> bundle_id{};
};

/// How often the flight controller sends one telemetry item.
enum class Rate : std::uint8_t { kOff = 0, k1Hz = 1, k10Hz = 2, k50Hz = 3, k100Hz = 4, kAsItIs = 5 };

struct TelemetryFrequency {
  std::array<Rate, 16> rates{};  ///< at the places of rate_places(); DJI reserves the others, which stay kOff
};

/// Up to 100 free bytes; used in both directions.
struct MobileData {
  static constexpr std::size_t kMaxBytes = 100;
  std::array<std::byte, kMaxBytes> bytes{};
  std::uint8_t size = 0;
  std::span<const std::byte> view() const { return std::span(bytes).first(size); }
};

struct ToMobile {
  MobileData data;
};

struct ControlRequest {
  bool obtain = true;
};

enum class Task : std::uint8_t { kGoHome = 1, kTakeOff = 4, kLand = 6 };

struct TaskRequest {
  std::uint8_t sequence = 0;  ///< number chosen by the client; TaskQuery names it
  Task task = Task::kTakeOff;
};

struct TaskQuery {
  std::uint8_t sequence = 0;
};

struct MotorRequest {
  bool start = false;
};

enum class HorizontalMode : std::uint8_t { kAngle = 0, kVelocity = 1, kPosition = 2 };
enum class VerticalMode : std::uint8_t { kVelocity = 0, kPosition = 1, kThrust = 2 };
enum class YawMode : std::uint8_t { kAngle = 0, kRate = 1 };
enum class HorizontalFrame : std::uint8_t { kGround = 0, kBody = 1 };

struct MovementMode {
  HorizontalMode horizontal = HorizontalMode::kAngle;
  VerticalMode vertical = VerticalMode::kVelocity;
  YawMode yaw = YawMode::kRate;
  HorizontalFrame frame = HorizontalFrame::kBody;
  bool stable = false;  ///< the autopilot holds its position while the horizontal command is zero
  friend constexpr bool operator==(const MovementMode&, const MovementMode&) = default;
};

constexpr std::uint8_t movement_flag(const MovementMode& mode) {
  return static_cast<std::uint8_t>(
      (static_cast<unsigned>(mode.horizontal) << 6U) | (static_cast<unsigned>(mode.vertical) << 4U) |
      (static_cast<unsigned>(mode.yaw) << 3U) | (static_cast<unsigned>(mode.frame) << 1U) | (mode.stable ? 1U : 0U));
}

/// @returns kInvalidArgument: a combination the M100 does not have (thrust exists with angles only).
core::Expected<MovementMode> movement_mode(std::uint8_t flag);

/// One set-point, executed only under control authority. Units and ranges depend on the mode:
///   x, y  angle: deg, +-30, x roll right, y pitch nose up | velocity: m/s, +-10, north/forward and east/right
///         position: offset from the present position in m
///   z     velocity: m/s, +-4, up | position: m above take-off, not negative | thrust: percent, 10..100
///   yaw   angle: deg, +-180 from north, clockwise | rate: deg/s, +-100, clockwise
struct Movement {
  std::uint8_t flag = 0;
  float x = 0.F;
  float y = 0.F;
  float z = 0.F;
  float yaw = 0.F;
};

struct GimbalRate {
  std::int16_t yaw_decideg_s = 0;  ///< each +-1800
  std::int16_t roll_decideg_s = 0;
  std::int16_t pitch_decideg_s = 0;
  std::uint8_t enable = 0x80;
};

struct GimbalAngle {
  std::int16_t yaw_decideg = 0;    ///< +-3200
  std::int16_t roll_decideg = 0;   ///< +-350
  std::int16_t pitch_decideg = 0;  ///< -900..300
  std::uint8_t flags = 1;          ///< bit 0 absolute; bits 1, 2, 3 ignore yaw, roll, pitch
  std::uint8_t duration_ds = 0;    ///< tenths of a second
};

enum class CameraAction : std::uint8_t { kPhoto = 0x20, kVideoStart = 0x21, kVideoStop = 0x22 };

struct CameraRequest {
  CameraAction action = CameraAction::kPhoto;
  std::uint8_t arbitrary = 0;
};

struct SyncPulse {
  std::uint32_t frequency_hz = 0;  ///< 0: one pulse
};

struct VirtualRcSwitch {
  bool on = false;
  bool fall_back_to_rc = true;  ///< true: the transmitter acts if virtual data stop; false: the RC-lost fail-safe does
  std::uint8_t reserved = 0;    ///< bits 2..7 as received; DJI's SDK never initialises them. Sent unchanged.
};

namespace vrc_channel {
inline constexpr std::size_t kRoll = 0;
inline constexpr std::size_t kPitch = 1;
inline constexpr std::size_t kThrottle = 2;
inline constexpr std::size_t kYaw = 3;
inline constexpr std::size_t kGear = 4;
inline constexpr std::size_t kMode = 6;
}  // namespace vrc_channel

inline constexpr std::uint32_t kStickCentre_counts = 1024;
inline constexpr std::uint32_t kStickLow_counts = 364;
inline constexpr std::uint32_t kStickHigh_counts = 1684;
inline constexpr std::uint32_t kGearUp_counts = 1684;
inline constexpr std::uint32_t kGearDown_counts = 1324;
inline constexpr std::uint32_t kModeP_counts = 1552;
inline constexpr std::uint32_t kModeA_counts = 1024;
inline constexpr std::uint32_t kModeF_counts = 496;

/// Sixteen channels in stick counts, 364..1684 each.
struct VirtualRcData {
  std::array<std::uint32_t, 16> channels{};
  /// Received only: arrived under the id of VirtualRcSwitch, a fault of DJI's SDK 3.3.0 to 4.1.0.
  bool under_switch_id = false;
};

using Command = std::variant<std::monostate, VersionQuery, Activation, TelemetryFrequency, ToMobile, ControlRequest,
                             TaskRequest, TaskQuery, MotorRequest, Movement, GimbalRate, GimbalAngle, CameraRequest,
                             SyncPulse, VirtualRcSwitch, VirtualRcData>;

constexpr MessageId id_of(const VersionQuery&) { return ids::kVersionQuery; }
constexpr MessageId id_of(const Activation&) { return ids::kActivation; }
constexpr MessageId id_of(const TelemetryFrequency&) { return ids::kTelemetryFrequency; }
constexpr MessageId id_of(const ToMobile&) { return ids::kToMobile; }
constexpr MessageId id_of(const ControlRequest&) { return ids::kControlRequest; }
constexpr MessageId id_of(const TaskRequest&) { return ids::kTask; }
constexpr MessageId id_of(const TaskQuery&) { return ids::kTaskQuery; }
constexpr MessageId id_of(const MotorRequest&) { return ids::kMotors; }
constexpr MessageId id_of(const Movement&) { return ids::kMovement; }
constexpr MessageId id_of(const GimbalRate&) { return ids::kGimbalRate; }
constexpr MessageId id_of(const GimbalAngle&) { return ids::kGimbalAngle; }
constexpr MessageId id_of(const CameraRequest& request) {
  return {ids::kPhoto.set, static_cast<std::uint8_t>(request.action)};
}
constexpr MessageId id_of(const SyncPulse&) { return ids::kSyncPulse; }
constexpr MessageId id_of(const VirtualRcSwitch&) { return ids::kVirtualRcSwitch; }
constexpr MessageId id_of(const VirtualRcData&) { return ids::kVirtualRcData; }

/// The value bytes of a command.
/// @returns kOutOfRange: a number is not finite or outside its range. kInvalidArgument: no such movement mode.
core::Expected<Value> encode(const VersionQuery& command);
core::Expected<Value> encode(const Activation& command);
core::Expected<Value> encode(const TelemetryFrequency& command);
core::Expected<Value> encode(const ToMobile& command);
core::Expected<Value> encode(const ControlRequest& command);
core::Expected<Value> encode(const TaskRequest& command);
core::Expected<Value> encode(const TaskQuery& command);
core::Expected<Value> encode(const MotorRequest& command);
core::Expected<Value> encode(const Movement& command);
core::Expected<Value> encode(const GimbalRate& command);
core::Expected<Value> encode(const GimbalAngle& command);
core::Expected<Value> encode(const CameraRequest& command);
core::Expected<Value> encode(const SyncPulse& command);
core::Expected<Value> encode(const VirtualRcSwitch& command);
core::Expected<Value> encode(const VirtualRcData& command);

/// kOk: the flag is a movement mode, and every number is finite and inside the range of that mode.
core::Status check(const Movement& command);
/// kOk if every channel is inside the travel of a stick.
core::Status check(const VirtualRcData& command);

}  // namespace m100::protocol
