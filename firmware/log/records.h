// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <type_traits>

namespace m100::log {

/// One tick of the flight: measurements, estimate, command of the law, supervised command. World NWU, body FLU, SI;
/// sticks in counts. No padding: kTickFormat describes the same layout for ULog, and a test compares the two.
struct TickRecord {
  std::uint64_t timestamp = 0;  ///< us
  std::array<double, 3> position{};
  std::array<double, 3> velocity{};
  std::array<double, 3> attitude{};      ///< roll, pitch in the yaw-free frame, yaw
  std::array<double, 2> tilt_rate{};     ///< roll, pitch, likewise
  std::array<double, 2> disturbance{};   ///< x, y, m/s^2
  std::array<double, 2> input_offset{};  ///< of pitch (x) and roll (y), rad
  double climb_offset = 0.0;
  std::array<double, 3> ref_position{};
  std::array<double, 3> ref_velocity{};
  std::array<double, 2> ref_acceleration{};
  double ref_yaw = 0.0;
  std::array<double, 3> pose_position{};  ///< as measured; the last one where pose_new is 0
  double pose_yaw = 0.0;
  std::array<double, 3> imu_attitude{};  ///< roll, pitch, yaw as measured
  std::array<double, 3> imu_rate{};
  std::array<double, 4> wanted{};         ///< roll, pitch, climb, yaw rate of law and excitation
  std::array<double, 4> granted{};        ///< likewise, of the supervisor
  float pose_age = 0.0F;                  ///< s, R3
  float telemetry_age = 0.0F;             ///< s
  float late = 0.0F;                      ///< s, time since the last tick beyond one period
  float residual = 0.0F;                  ///< of the residual monitor: worst channel over its expected value
  std::array<std::uint16_t, 4> sticks{};  ///< roll, pitch, throttle, yaw as last sent
  std::uint32_t facts = 0;                ///< safety::FailsafeCondition
  std::uint32_t refused_poses = 0;        ///< by the gate, in a row
  std::uint32_t dropped_messages = 0;     ///< of this log
  std::uint8_t state = 0;                 ///< safety::FailsafeState
  std::uint8_t sent = 0;                  ///< 1: a control frame was sent in this tick
  std::uint8_t pose_new = 0;
  std::uint8_t imu_new = 0;
  std::uint8_t link_state = 0;  ///< safety::AuthorityStage
  std::uint8_t mpc_path_x = 0;
  std::uint8_t mpc_path_y = 0;
  std::uint8_t mpc_changes = 0;  ///< of the active sets, both axes; 255: as many or more
  std::uint32_t orders = 0;      ///< of the operator, given before this tick: kOrder*
};
static_assert(std::is_trivially_copyable_v<TickRecord>);
static_assert(sizeof(TickRecord) == 8 + 8 * (3 + 3 + 3 + 2 + 2 + 2 + 1 + 3 + 3 + 2 + 1 + 3 + 1 + 3 + 3 + 4 + 4) +
                                        4 * 4 + 2 * 4 + 4 * 3 + 8 + 4);

inline constexpr std::uint32_t kOrderEngage = 1;
inline constexpr std::uint32_t kOrderRelease = 2;
inline constexpr std::uint32_t kOrderTakesOff =
    4;  ///< the autopilot flies a task of its own, or is about to, from the ground
inline constexpr std::uint32_t kOrderLands =
    8;  ///< likewise, in the air; with kOrderRelease: end it; with kOrderEngage: hover instead
inline constexpr std::uint32_t kOrderTask = 16;  ///< that task was requested before this tick

inline constexpr std::string_view kTickFormat =
    "tick:uint64_t timestamp;double[3] position;double[3] velocity;double[3] attitude;double[2] tilt_rate;"
    "double[2] disturbance;double[2] input_offset;double climb_offset;double[3] ref_position;double[3] ref_velocity;"
    "double[2] ref_acceleration;double ref_yaw;double[3] pose_position;double pose_yaw;double[3] imu_attitude;"
    "double[3] imu_rate;double[4] wanted;double[4] granted;float pose_age;float telemetry_age;float late;"
    "float residual;uint16_t[4] sticks;uint32_t facts;uint32_t refused_poses;uint32_t dropped_messages;uint8_t state;"
    "uint8_t sent;uint8_t pose_new;uint8_t imu_new;uint8_t link_state;uint8_t mpc_path_x;uint8_t mpc_path_y;"
    "uint8_t mpc_changes;uint32_t orders;";

/// One tick from the start of an excitation on: the stick that it moves, and distance from the reference and speed
/// along the axis, positive in the direction of the stick: m and m/s, for yaw rad and rad/s.
struct ExcitationRecord {
  std::uint64_t timestamp = 0;  ///< us
  float distance = 0.0F;
  float speed = 0.0F;
  std::int16_t counts = 0;   ///< from the trim, as planned; 0 while the law has the stick
  std::uint16_t sample = 0;  ///< its number in the piece
  std::uint8_t piece = 0;
  std::uint8_t axis = 0;   ///< 0 roll, 1 pitch, 2 throttle, 3 yaw
  std::uint8_t state = 0;  ///< 1 the law returns to the place, 2 the stick moves, 3 over, 4 aborted
  std::uint8_t abort = 0;  ///< 0 none, 1 failsafe, 2 fence, 3 distance, 4 tilt, 5 speed, 6 not at rest
};
static_assert(sizeof(ExcitationRecord) == 24);

inline constexpr std::string_view kExcitationFormat =
    "excitation:uint64_t timestamp;float distance;float speed;int16_t counts;uint16_t sample;uint8_t piece;uint8_t "
    "axis;"
    "uint8_t state;uint8_t abort;";

/// Once a second: est::VibrationStatus, of one axis above 15 Hz. Older logs have none.
struct VibrationRecord {
  std::uint64_t timestamp = 0;  ///< us
  float rms = 0.0F;             ///< m/s^2; not a number: telemetry is too slow to see 15 Hz
  float peak = 0.0F;            ///< m/s^2, fading
  float clipped = 0.0F;         ///< share of the messages at the end of the sensor's range
  float velocity_sigma = 0.0F;  ///< m/s: one sigma of an axis of the velocity that the check of the force compares
};
static_assert(sizeof(VibrationRecord) == 24);

inline constexpr std::string_view kVibrationFormat =
    "vibration:uint64_t timestamp;float rms;float peak;float clipped;float velocity_sigma;";

/// Where bytes came from or went to.
enum class Stream : std::uint8_t { kAutopilotIn = 0, kAutopilotOut = 1, kPoseIn = 2, kPoseOut = 3 };

/// Raw bytes of one direction, from one read or write of the tick at `timestamp`; longer ones take several records.
struct BytesRecord {
  std::uint64_t timestamp = 0;
  std::uint8_t stream = 0;
  std::uint8_t count = 0;
  std::array<std::uint8_t, 118> bytes{};
};
static_assert(sizeof(BytesRecord) == 128);

inline constexpr std::string_view kBytesFormat =
    "link_bytes:uint64_t timestamp;uint8_t stream;uint8_t count;uint8_t[118] bytes;";

}  // namespace m100::log
