// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <tuple>

#include "protocol/mavlink/layout.h"

namespace m100::mavlink {

// Messages of the pose source.
// Members have the names of the message definitions, so that engineers who know those find them.
// Deviation: these names lack units; the comment of each structure gives them.

/// ATT_POS_MOCAP: attitude of the body (FRD) in NED as a quaternion w, x, y, z; position in m; covariance is the upper
/// triangle of a 6x6 matrix, row by row.
struct AttPosMocap {
  std::uint64_t time_usec{};
  std::array<float, 4> q{};
  float x{};
  float y{};
  float z{};
  std::array<float, 21> covariance{};
  static constexpr MessageInfo kInfo{.id = 138, .crc_extra = 109, .min_bytes = 36, .full_bytes = 120};
};

template <>
inline constexpr auto kFields<AttPosMocap> = std::tuple{field("time_usec", &AttPosMocap::time_usec),
                                                        field("q", &AttPosMocap::q),
                                                        field("x", &AttPosMocap::x),
                                                        field("y", &AttPosMocap::y),
                                                        field("z", &AttPosMocap::z),
                                                        field("covariance", &AttPosMocap::covariance)};

/// VISION_POSITION_ESTIMATE: NED, m and rad; covariance is the upper triangle of a 6x6 matrix, row by row.
struct VisionPositionEstimate {
  std::uint64_t usec{};
  float x{};
  float y{};
  float z{};
  float roll{};
  float pitch{};
  float yaw{};
  std::array<float, 21> covariance{};
  std::uint8_t reset_counter{};
  static constexpr MessageInfo kInfo{.id = 102, .crc_extra = 158, .min_bytes = 32, .full_bytes = 117};
};

template <>
inline constexpr auto kFields<VisionPositionEstimate> =
    std::tuple{field("usec", &VisionPositionEstimate::usec),
               field("x", &VisionPositionEstimate::x),
               field("y", &VisionPositionEstimate::y),
               field("z", &VisionPositionEstimate::z),
               field("roll", &VisionPositionEstimate::roll),
               field("pitch", &VisionPositionEstimate::pitch),
               field("yaw", &VisionPositionEstimate::yaw),
               field("covariance", &VisionPositionEstimate::covariance),
               field("reset_counter", &VisionPositionEstimate::reset_counter)};

/// ODOMETRY: position in m and attitude in frame_id, velocities in m/s and rad/s in child_frame_id.
struct Odometry {
  std::uint64_t time_usec{};
  float x{};
  float y{};
  float z{};
  std::array<float, 4> q{};
  float vx{};
  float vy{};
  float vz{};
  float rollspeed{};
  float pitchspeed{};
  float yawspeed{};
  std::array<float, 21> pose_covariance{};
  std::array<float, 21> velocity_covariance{};
  std::uint8_t frame_id{};
  std::uint8_t child_frame_id{};
  std::uint8_t reset_counter{};
  std::uint8_t estimator_type{};
  std::int8_t quality{};
  static constexpr MessageInfo kInfo{.id = 331, .crc_extra = 91, .min_bytes = 230, .full_bytes = 233};
};

template <>
inline constexpr auto kFields<Odometry> = std::tuple{field("time_usec", &Odometry::time_usec),
                                                     field("x", &Odometry::x),
                                                     field("y", &Odometry::y),
                                                     field("z", &Odometry::z),
                                                     field("q", &Odometry::q),
                                                     field("vx", &Odometry::vx),
                                                     field("vy", &Odometry::vy),
                                                     field("vz", &Odometry::vz),
                                                     field("rollspeed", &Odometry::rollspeed),
                                                     field("pitchspeed", &Odometry::pitchspeed),
                                                     field("yawspeed", &Odometry::yawspeed),
                                                     field("pose_covariance", &Odometry::pose_covariance),
                                                     field("velocity_covariance", &Odometry::velocity_covariance),
                                                     field("frame_id", &Odometry::frame_id),
                                                     field("child_frame_id", &Odometry::child_frame_id),
                                                     field("reset_counter", &Odometry::reset_counter),
                                                     field("estimator_type", &Odometry::estimator_type),
                                                     field("quality", &Odometry::quality)};

/// TIMESYNC: a request has tc1 zero and the time of the requesting side in ts1; the answer returns ts1, with the time
/// of the answering side in tc1 [ns].
struct Timesync {
  std::int64_t tc1{};
  std::int64_t ts1{};
  std::uint8_t target_system{};
  std::uint8_t target_component{};
  static constexpr MessageInfo kInfo{.id = 111, .crc_extra = 34, .min_bytes = 16, .full_bytes = 18};
};

template <>
inline constexpr auto kFields<Timesync> = std::tuple{field("tc1", &Timesync::tc1), field("ts1", &Timesync::ts1),
                                                     field("target_system", &Timesync::target_system),
                                                     field("target_component", &Timesync::target_component)};

}  // namespace m100::mavlink
