// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "firmware/safety/rows.h"
#include "firmware/safety/signs.h"

namespace m100::safety {

/// The failsafe ladder, from the top down, with the command that each rung lets through:
///   kNominal  the law's command
///   kCoast    the law's command, computed from the model's prediction, for a limited time; the command of kLevel once
///             the predicted error reaches the fence
///   kLevel    a command that brakes, then holds trim and wind as last estimated; no climb, no turn: the autopilot
///             holds the height. Also the rung while the autopilot takes off or lands by its own task
///   kRelease  level and trimmed, and control is about to be given back
///   kSilent   nothing: control is not ours
enum class Rung : std::uint8_t { kSilent, kNominal, kCoast, kLevel, kRelease };

/// Conditions that the table tests; a set of them is a bit mask.
enum class LadderSign : std::uint32_t {
  kNone = 0,
  kCommandable = 1U << 0U,       ///< authority is ours and the mode switch stands at F
  kOperatorReleases = 1U << 1U,  ///< given back on purpose
  kTelemetryDead = 1U << 2U,     ///< the autopilot has been silent for 500 ms
  kCommandUnsound = 1U << 3U,    ///< the law's command is not finite or far out of range
  kEstimateLost = 1U << 4U,      ///< gate shut for 0.3 s, or covariance beyond its limit
  kFresh = 1U << 5U,             ///< pose younger than fresh_limit() and telemetry than 100 ms
  kRecovered = 1U << 6U,         ///< fresh, and ten new poses in a row
  kCoastOver = 1U << 7U,         ///< in kCoast for 700 ms in which the error never fell back to its first value
  kLevelOver = 1U << 8U,         ///< in kLevel for 1 s, and slow enough for the pilot
  kNeutralOver = 1U << 9U,       ///< in kRelease for 0.5 s
  kOperatorEngages = 1U << 10U,  ///< asked to fly, by a person
  // Reported, not acted upon: no row of the table tests these. They are in the log's field `facts`.
  kRollLeftModel = 1U << 11U,   ///< the axis no longer follows its model, by the residual monitor; likewise below
  kPitchLeftModel = 1U << 12U,  ///< in the order of sysid::MonitoredAxis
  kYawRateLeftModel = 1U << 13U,
  kClimbLeftModel = 1U << 14U,
  kTrimDrifted = 1U << 15U,  ///< in hover, by est::TrimWatch
  // Acted upon again.
  kReserveSpent = 1U << 16U,  ///< 500 ms in kCoast, and the predicted error of the position reached the fence
  kOutside = 1U << 17U,       ///< the aircraft is beyond a side of its fence
  kPlaceLost = 1U << 18U,     ///< for 3 s the wind has been stronger than the aircraft
  kTaskFlies = 1U << 19U,     ///< the autopilot takes off or lands by its own task, by the operator's order
  kSwings = 1U << 20U,        ///< reported only: the tilt swung by itself, and the calm law flies (ctl::SwingWatch)
  kSwingsOn = 1U << 21U,      ///< acted upon: the swing continues under the calm law
};
template <>
inline constexpr bool kIsSign<LadderSign> = true;

/// Why a step was made. A row names its cause; if a sign has several causes, the supervisor determines which one it is.
enum class Cause : std::uint8_t {
  kNone,
  kControlGone,      ///< authority or mode F: the link says which
  kGivenBack,        ///< by the operator
  kTelemetrySilent,  ///< nothing from the autopilot for 500 ms
  kCommandUnsound,   ///< the law's command was not finite or far out of range
  kPoseRefused,      ///< the gate shut
  kEstimateLost,     ///< not started, attitude gone, or covariance beyond its limit
  kPoseOld,
  kTelemetryOld,
  kCoastOver,
  kLevelOver,
  kNeutralOver,
  kRecovered,
  kEngaged,       ///< by the operator
  kReserveSpent,  ///< further coasting might leave the fence
  kFenceLeft,
  kPlaceLost,  ///< the wind is stronger than the aircraft
  kTask,       ///< the autopilot takes off or lands, by the operator's order
  kSwinging,   ///< the tilt swings by itself, even under the calm law
};
inline constexpr std::size_t kCauseCount = 19;

std::string_view name(Rung rung);
std::string_view name(Cause cause);

/// In `from`, with all of `needs` and none of `excludes`: go to `to`, because of `why`.
struct LadderRow {
  Rung from;
  LadderSign needs;
  LadderSign excludes;
  Rung to;
  Cause why;
};

/// Read from the top, first match wins; no match: stay. Rows that take authority away come first in every state.
inline constexpr std::array kLadder{
    // The pilot, the app or a mission took control: stop at once, and never request it again without the operator.
    LadderRow{Rung::kNominal, LadderSign::kNone, LadderSign::kCommandable, Rung::kSilent, Cause::kControlGone},
    LadderRow{Rung::kCoast, LadderSign::kNone, LadderSign::kCommandable, Rung::kSilent, Cause::kControlGone},
    LadderRow{Rung::kLevel, LadderSign::kNone, LadderSign::kCommandable, Rung::kSilent, Cause::kControlGone},
    LadderRow{Rung::kRelease, LadderSign::kNone, LadderSign::kCommandable, Rung::kSilent, Cause::kControlGone},
    // The way out.
    LadderRow{Rung::kRelease, LadderSign::kNeutralOver, LadderSign::kNone, Rung::kSilent, Cause::kNeutralOver},
    LadderRow{Rung::kNominal, LadderSign::kOperatorReleases, LadderSign::kNone, Rung::kRelease, Cause::kGivenBack},
    LadderRow{Rung::kCoast, LadderSign::kOperatorReleases, LadderSign::kNone, Rung::kRelease, Cause::kGivenBack},
    LadderRow{Rung::kLevel, LadderSign::kOperatorReleases, LadderSign::kNone, Rung::kRelease, Cause::kGivenBack},
    LadderRow{Rung::kNominal, LadderSign::kTelemetryDead, LadderSign::kNone, Rung::kRelease, Cause::kTelemetrySilent},
    LadderRow{Rung::kCoast, LadderSign::kTelemetryDead, LadderSign::kNone, Rung::kRelease, Cause::kTelemetrySilent},
    LadderRow{Rung::kLevel, LadderSign::kTelemetryDead, LadderSign::kNone, Rung::kRelease, Cause::kTelemetrySilent},
    // An order to fly that can be obeyed is obeyed even at the last moment; one that cannot does not delay the pilot.
    LadderRow{Rung::kLevel, LadderSign::kOperatorEngages | LadderSign::kRecovered,
              LadderSign::kEstimateLost | LadderSign::kCommandUnsound | LadderSign::kOutside | LadderSign::kTaskFlies,
              Rung::kNominal, Cause::kEngaged},
    LadderRow{Rung::kLevel, LadderSign::kLevelOver, LadderSign::kNone, Rung::kRelease, Cause::kLevelOver},
    // While the autopilot flies its own task the law is inactive and the sticks are level: the task needs no pose.
    LadderRow{Rung::kNominal, LadderSign::kTaskFlies, LadderSign::kNone, Rung::kLevel, Cause::kTask},
    LadderRow{Rung::kCoast, LadderSign::kTaskFlies, LadderSign::kNone, Rung::kLevel, Cause::kTask},
    LadderRow{Rung::kSilent, LadderSign::kTaskFlies | LadderSign::kCommandable,
              LadderSign::kOperatorReleases | LadderSign::kTelemetryDead, Rung::kLevel, Cause::kTask},
    // Down one step.
    LadderRow{Rung::kNominal, LadderSign::kCommandUnsound, LadderSign::kNone, Rung::kLevel, Cause::kCommandUnsound},
    LadderRow{Rung::kCoast, LadderSign::kCommandUnsound, LadderSign::kNone, Rung::kLevel, Cause::kCommandUnsound},
    LadderRow{Rung::kNominal, LadderSign::kEstimateLost, LadderSign::kNone, Rung::kLevel, Cause::kEstimateLost},
    LadderRow{Rung::kCoast, LadderSign::kEstimateLost, LadderSign::kNone, Rung::kLevel, Cause::kEstimateLost},
    LadderRow{Rung::kNominal, LadderSign::kOutside, LadderSign::kNone, Rung::kLevel, Cause::kFenceLeft},
    LadderRow{Rung::kCoast, LadderSign::kOutside, LadderSign::kNone, Rung::kLevel, Cause::kFenceLeft},
    LadderRow{Rung::kNominal, LadderSign::kPlaceLost, LadderSign::kNone, Rung::kLevel, Cause::kPlaceLost},
    LadderRow{Rung::kNominal, LadderSign::kSwingsOn, LadderSign::kNone, Rung::kLevel, Cause::kSwinging},
    LadderRow{Rung::kCoast, LadderSign::kReserveSpent, LadderSign::kFresh, Rung::kLevel, Cause::kReserveSpent},
    LadderRow{Rung::kCoast, LadderSign::kCoastOver, LadderSign::kFresh, Rung::kLevel, Cause::kCoastOver},
    LadderRow{Rung::kNominal, LadderSign::kNone, LadderSign::kFresh, Rung::kCoast, Cause::kPoseOld},
    // Up again: from kCoast by itself, from kLevel (above) and kSilent only by the operator.
    LadderRow{Rung::kCoast, LadderSign::kRecovered, LadderSign::kNone, Rung::kNominal, Cause::kRecovered},
    LadderRow{Rung::kSilent, LadderSign::kOperatorEngages | LadderSign::kCommandable | LadderSign::kRecovered,
              LadderSign::kEstimateLost | LadderSign::kCommandUnsound | LadderSign::kOperatorReleases |
                  LadderSign::kTelemetryDead | LadderSign::kOutside,
              Rung::kNominal, Cause::kEngaged},
};

/// Number of the row that matches; the table's size if none does.
constexpr std::size_t row_number(Rung state, LadderSign signs) {
  return first_row(kLadder, [state, signs](const LadderRow& row) {
    return row.from == state && all(signs, row.needs) && !any(signs, row.excludes);
  });
}

/// The rung after one look-up in the table.
constexpr Rung next_rung(Rung state, LadderSign signs) {
  const std::size_t number = row_number(state, signs);
  return number < kLadder.size() ? kLadder[number].to : state;
}

/// Whether the law's command may leave in this state, and whether any control byte may.
constexpr bool passes_law(Rung state) { return state == Rung::kNominal || state == Rung::kCoast; }
constexpr bool may_transmit(Rung state) { return state != Rung::kSilent; }

static_assert(next_rung(Rung::kNominal, LadderSign::kFresh | LadderSign::kRecovered) == Rung::kSilent,
              "the pilot comes first");
static_assert(next_rung(Rung::kNominal, LadderSign::kCommandable | LadderSign::kFresh) == Rung::kNominal);
static_assert(next_rung(Rung::kNominal, LadderSign::kCommandable) == Rung::kCoast);
static_assert(next_rung(Rung::kCoast, LadderSign::kCommandable | LadderSign::kCoastOver) == Rung::kLevel);
static_assert(next_rung(Rung::kCoast, LadderSign::kCommandable | LadderSign::kCoastOver | LadderSign::kFresh) ==
                  Rung::kCoast,
              "poses are back: ten of them decide");
static_assert(next_rung(Rung::kLevel, LadderSign::kCommandable | LadderSign::kFresh | LadderSign::kRecovered) ==
                  Rung::kLevel,
              "from level back only by the operator");
static_assert(next_rung(Rung::kSilent, LadderSign::kCommandable | LadderSign::kFresh | LadderSign::kRecovered) ==
                  Rung::kSilent,
              "nobody flies unasked");
static_assert(next_rung(Rung::kLevel, LadderSign::kTaskFlies) == Rung::kSilent, "the pilot ends a task, too");
static_assert(next_rung(Rung::kLevel, LadderSign::kCommandable | LadderSign::kTaskFlies |
                                          LadderSign::kOperatorReleases) == Rung::kRelease);
static_assert(next_rung(Rung::kSilent, LadderSign::kCommandable | LadderSign::kTaskFlies | LadderSign::kRecovered |
                                           LadderSign::kOperatorEngages) == Rung::kLevel,
              "the law waits for the end of a take-off");

}  // namespace m100::safety
