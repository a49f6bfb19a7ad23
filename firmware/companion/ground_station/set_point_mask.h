// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <initializer_list>

#include "protocol/mavlink/command_messages.h"

// Bits of type_mask (MAVLink POSITION_TARGET_TYPEMASK): a set bit means that the field is ignored.
namespace m100::companion {

inline constexpr unsigned kIgnorePosition = 0b111;
inline constexpr unsigned kIgnoreVelocity = 0b111000;
inline constexpr unsigned kIgnoreAcceleration = 0b111000000;
inline constexpr unsigned kForce = 1U << 9U;  ///< the acceleration is a force
inline constexpr unsigned kIgnoreYaw = 1U << 10U;
inline constexpr unsigned kIgnoreYawRate = 1U << 11U;

inline constexpr std::uint8_t kLocalNed = 1;  ///< MAV_FRAME

inline constexpr double kFarthestSetPoint = 1000.0;  ///< largest number in one, of any unit

inline bool names(const mavlink::SetPositionTargetLocalNed& set_point, unsigned fields) {
  return (set_point.type_mask & fields) == 0;
}
inline bool ignores(const mavlink::SetPositionTargetLocalNed& set_point, unsigned fields) {
  return (set_point.type_mask & fields) == fields;
}

/// A place, and no motion: what a goal may name.
inline bool names_only_a_place(const mavlink::SetPositionTargetLocalNed& set_point) {
  return ignores(set_point, kIgnoreVelocity | kIgnoreAcceleration | kIgnoreYawRate) &&
         (set_point.type_mask & kForce) == 0;
}

/// Each group is named as a whole or not at all, and an acceleration not alone.
inline bool is_whole(const mavlink::SetPositionTargetLocalNed& set_point) {
  const auto whole = [&](unsigned group) { return names(set_point, group) || ignores(set_point, group); };
  const bool moves = names(set_point, kIgnorePosition) || names(set_point, kIgnoreVelocity);
  return moves && whole(kIgnorePosition) && whole(kIgnoreVelocity) && whole(kIgnoreAcceleration) &&
         (set_point.type_mask & kForce) == 0;
}

inline bool is_finite(const mavlink::SetPositionTargetLocalNed& set_point) {
  const auto fine = [&](unsigned group, std::initializer_list<float> values) {
    return !names(set_point, group) || std::all_of(values.begin(), values.end(), [](float value) {
      return std::abs(static_cast<double>(value)) <= kFarthestSetPoint;  // false for a NaN
    });
  };
  return fine(kIgnorePosition, {set_point.x, set_point.y, set_point.z}) &&
         fine(kIgnoreVelocity, {set_point.vx, set_point.vy, set_point.vz}) &&
         fine(kIgnoreAcceleration, {set_point.afx, set_point.afy, set_point.afz}) &&
         fine(kIgnoreYaw, {set_point.yaw}) && fine(kIgnoreYawRate, {set_point.yaw_rate});
}

}  // namespace m100::companion
