// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

namespace m100::est {

/// The consistency checks. VelocityConsistency and HeightConsistency compare the pose's motion with the autopilot's.
/// AttitudeRateConsistency and CommandConsistency compare the attitude with its rates and with our commands.
enum class ConsistencyCheck : std::uint8_t {
  kNone,
  kForce,    ///< change of horizontal velocity, against the specific force; m/s
  kClimb,    ///< climb speed, against the autopilot's; m/s
  kHeading,  ///< change of heading, against the autopilot's; rad
  kMotion,   ///< the path of the last seconds, against that of the specific force; m
  kRates,    ///< change of tilt, against the rates of the autopilot; rad
  kAnswer,   ///< the tilt, against our own commands; rad
  kHeight,   ///< the height, against the autopilot's height and climb speed over tens of seconds; m
};
inline constexpr std::size_t kCheckCount = 8;
std::string_view name(ConsistencyCheck check);
std::string_view unit_of(ConsistencyCheck check);
/// The check that has this name. nullopt if there is none, or if the name is that of kNone.
std::optional<ConsistencyCheck> check_of(std::string_view name);

/// A set of checks, one bit each.
using CheckSet = std::uint8_t;
constexpr CheckSet set_of(ConsistencyCheck check) {
  return check == ConsistencyCheck::kNone ? CheckSet{0} : static_cast<CheckSet>(1U << static_cast<unsigned>(check));
}

/// The check that contradicts the pose or the attitude.
template <typename T>
struct Contradiction {
  ConsistencyCheck check = ConsistencyCheck::kNone;  ///< kNone: none does
  T measured{0};                                     ///< the disagreement, in unit_of(check)
  T allowed{0};
};

}  // namespace m100::est
