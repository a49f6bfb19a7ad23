// SPDX-License-Identifier: BSD-3-Clause
#include <array>

#include "firmware/safety/ladder.h"

namespace m100::safety {
namespace {

constexpr std::array<std::string_view, 5> kRungNames{"silent", "nominal", "coast", "level", "release"};
constexpr std::array<std::string_view, kCauseCount> kCauseNames{
    "none",         "control_gone",  "given_back", "telemetry_silent", "command_unsound",
    "pose_refused", "estimate_lost", "pose_old",   "telemetry_old",    "coast_over",
    "level_over",   "neutral_over",  "recovered",  "engaged",          "reserve_spent",
    "fence_left",   "place_lost",    "task",       "swinging"};
static_assert(static_cast<std::size_t>(Cause::kSwinging) + 1 == kCauseCount);

}  // namespace

std::string_view name(Rung rung) { return kRungNames[static_cast<std::size_t>(rung)]; }
std::string_view name(Cause cause) { return kCauseNames[static_cast<std::size_t>(cause)]; }

}  // namespace m100::safety
