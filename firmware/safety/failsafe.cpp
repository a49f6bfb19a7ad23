// SPDX-License-Identifier: BSD-3-Clause
#include <array>

#include "firmware/safety/failsafe.h"

namespace m100::safety {
namespace {

constexpr std::array<std::string_view, 5> kFailsafeStateNames{"silent", "nominal", "coast", "level", "release"};
constexpr std::array<std::string_view, kFailsafeReasonCount> kFailsafeReasonNames{
    "none",          "control_gone", "given_back",     "telemetry_silent", "command_unsound", "pose_refused",
    "estimate_lost", "pose_old",     "telemetry_old",  "coast_over",       "level_over",      "neutral_over",
    "recovered",     "engaged",      "reserve_spent",  "fence_left",       "place_lost",      "task",
    "swinging",      "on_ground",    "flight_failure", "vibration"};
static_assert(static_cast<std::size_t>(FailsafeReason::kVibration) + 1 == kFailsafeReasonCount);

}  // namespace

std::string_view name(FailsafeState failsafe_state) {
  return kFailsafeStateNames[static_cast<std::size_t>(failsafe_state)];
}
std::string_view name(FailsafeReason cause) { return kFailsafeReasonNames[static_cast<std::size_t>(cause)]; }

}  // namespace m100::safety
