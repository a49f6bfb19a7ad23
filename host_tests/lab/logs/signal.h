// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

namespace m100::lab::logs {

/// The canonical signals. Units and frames: sticks in counts from neutral (positive: roll right, pitch forward,
/// throttle up, yaw right); commands in rad, rad/s and m/s; attitude z-y-x Euler angles of the forward-left-up body
/// [rad]; rates in the body [rad/s]; position, velocity in the world, z up [m, m/s]; force is the specific force in the
/// body [m/s^2]; thrust_ratio is thrust over weight, thrust_dir the body z axis in the world. A quaternion rotates a
/// body vector into a world vector; a loaded log holds its angles instead.
enum class Signal : std::uint8_t {
  kStickRoll,
  kStickPitch,
  kStickThrottle,
  kStickYaw,
  kCommandRoll,
  kCommandPitch,
  kCommandYawRate,
  kCommandClimb,
  kAttitudeRoll,
  kAttitudePitch,
  kAttitudeYaw,
  kRateX,
  kRateY,
  kRateZ,
  kPositionX,
  kPositionY,
  kPositionZ,
  kVelocityX,
  kVelocityY,
  kVelocityZ,
  kForceX,
  kForceY,
  kForceZ,
  kThrustRatio,
  kThrustDirX,
  kThrustDirY,
  kThrustDirZ,
  kAttitudeQw,
  kAttitudeQx,
  kAttitudeQy,
  kAttitudeQz,
  kCommandQw,
  kCommandQx,
  kCommandQy,
  kCommandQz,
  kSequence,
  kCount
};

inline constexpr std::size_t kSignals = static_cast<std::size_t>(Signal::kCount);

inline constexpr std::array<std::string_view, kSignals> kSignalNames{
    "stick_roll",       "stick_pitch",   "stick_throttle", "stick_yaw",      "command_roll", "command_pitch",
    "command_yaw_rate", "command_climb", "attitude_roll",  "attitude_pitch", "attitude_yaw", "rate_x",
    "rate_y",           "rate_z",        "position_x",     "position_y",     "position_z",   "velocity_x",
    "velocity_y",       "velocity_z",    "force_x",        "force_y",        "force_z",      "thrust_ratio",
    "thrust_dir_x",     "thrust_dir_y",  "thrust_dir_z",   "attitude_qw",    "attitude_qx",  "attitude_qy",
    "attitude_qz",      "command_qw",    "command_qx",     "command_qy",     "command_qz",   "sequence"};

constexpr std::string_view name_of(Signal signal) { return kSignalNames[static_cast<std::size_t>(signal)]; }

constexpr std::optional<Signal> signal_of(std::string_view name) {
  for (std::size_t i = 0; i < kSignals; ++i) {
    if (kSignalNames[i] == name) {
      return static_cast<Signal>(i);
    }
  }
  return std::nullopt;
}

/// -1 for signals with the opposite sign in a log of the convention north-east-down, forward-right-down, otherwise 1.
/// Ours (NWU, FLU) and that one differ by half a turn about x, in the world and in the body alike. Sticks are counts
/// and have no frame. thrust_dir is the body's z axis, which is itself reversed there: so only its x changes sign.
constexpr double sign_in_ned_frd(Signal signal) {
  using enum Signal;
  constexpr std::array kTurned{kCommandPitch, kCommandYawRate, kCommandClimb, kAttitudePitch, kAttitudeYaw, kRateY,
                               kRateZ,        kPositionY,      kPositionZ,    kVelocityY,     kVelocityZ,   kForceY,
                               kForceZ,       kThrustDirX,     kAttitudeQy,   kAttitudeQz,    kCommandQy,   kCommandQz};
  return std::find(kTurned.begin(), kTurned.end(), signal) == kTurned.end() ? 1.0 : -1.0;
}

/// The n-th signal of a group of neighbours: offset(Signal::kRateX, 2) is kRateZ.
constexpr Signal offset(Signal first, int n) { return static_cast<Signal>(static_cast<int>(first) + n); }

}  // namespace m100::lab::logs
