// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace m100::link {

/// Why a pose was refused; each has a counter and a sentence of its own.
enum class PoseFault : std::uint8_t {
  kNone,
  kZeros,
  kNotFinite,
  kQuaternion,
  kDegrees,
  kMillimetres,
  kFrame,
  kQuality,
  kVariance,
  kFastStamp,
  kSlowStamp,
  kOrder,
  kSender,
};
inline constexpr std::size_t kPoseFaults = 13;

struct PoseFaultText {
  std::string_view name;      ///< in JSON
  std::string_view sentence;  ///< what came, and what it should be
};

inline constexpr std::array<PoseFaultText, kPoseFaults> kPoseFaultTexts{
    PoseFaultText{"none", ""},
    PoseFaultText{"zeros", "all zeros: the source does not see the object"},
    PoseFaultText{"not_finite", "a number that is not finite"},
    PoseFaultText{"quaternion", "a quaternion whose length is not 1"},
    PoseFaultText{"degrees", "angles beyond 2 pi: degrees? MAVLink's angles are radians"},
    PoseFaultText{"millimetres", "a position beyond 1 km: millimetres? MAVLink's positions are metres"},
    PoseFaultText{"frame",
                  "ODOMETRY in a frame that is neither NED nor FRD (ENU or FLU?): use frame 1, 14, 16, 18 or 20"},
    PoseFaultText{"quality", "ODOMETRY of a negative quality: the source says that it has lost its track"},
    PoseFaultText{
        "variance",
        "a variance that cannot be flown inside this fence: from its middle, three sigmas reach beyond a side; "
        "take a larger fence or a better source, or, if its covariance means nothing, state its sigma_m in the "
        "flight file's [pose]"},
    PoseFaultText{"fast_stamp", "time stamps that run far too fast: nanoseconds? MAVLink's are microseconds"},
    PoseFaultText{
        "slow_stamp",
        "time stamps that stand still or run far too slowly: milliseconds or seconds? MAVLink's are microseconds"},
    PoseFaultText{"order", "time stamps that do not rise: doubled, overtaken, or by a clock that was just set"},
    PoseFaultText{"sender", "poses of another sender"},
};

constexpr const PoseFaultText& text_of(PoseFault fault) { return kPoseFaultTexts[static_cast<std::size_t>(fault)]; }

}  // namespace m100::link
