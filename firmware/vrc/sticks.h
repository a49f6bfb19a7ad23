// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace m100::vrc {

/// A stick position in counts of the Virtual RC, 364..1684, centre 1024 (protocol, section 7).
enum class Stick : std::uint16_t {};

inline constexpr Stick kStickCentre{1024};
inline constexpr Stick kStickLow{364};
inline constexpr Stick kStickHigh{1684};

/// The four sticks. Larger numbers: roll to the right, pitch forward, throttle up, yaw to the right (clockwise).
struct Sticks {
  Stick roll = kStickCentre;
  Stick pitch = kStickCentre;
  Stick throttle = kStickCentre;
  Stick yaw = kStickCentre;
};

}  // namespace m100::vrc
