// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "firmware/safety/condition_set.h"
#include "firmware/safety/transition_table.h"

namespace m100::safety {

/// The states of the failsafe, from normal flight down, with the command that each state lets through:
///   kNominal  the law's command
///   kCoast    the law's command, computed from the model's prediction, for a limited time; the command of kLevel once
///             the predicted error reaches the fence
///   kLevel    a command that brakes, then holds trim and wind as last estimated; no climb, no turn: the autopilot
///             holds the height. Also the state while the autopilot takes off or lands by its own task
///   kRelease  the command of kLevel if that came before, else level and trimmed; control is about to be given back
///   kSilent   nothing: control is not ours, or is not used
enum class FailsafeState : std::uint8_t { kSilent, kNominal, kCoast, kLevel, kRelease };

/// Conditions that the table tests; a set of them is a bit mask.
enum class FailsafeCondition : std::uint32_t {
  kNone = 0,
  kCommandable = 1U << 0U,       ///< authority is ours and the mode switch is at F
  kOperatorReleases = 1U << 1U,  ///< the operator gives control back
  kTelemetryDead = 1U << 2U,     ///< no telemetry package for 500 ms
  kCommandInvalid = 1U << 3U,    ///< the law's command is not finite or far out of range
  kEstimateLost = 1U << 4U,      ///< poses refused for 0.3 s or contradicted, or not Estimate::healthy
  kFresh = 1U << 5U,             ///< the pose is at most fresh_limit() old, and telemetry 100 ms
  kRecovered = 1U << 6U,         ///< kFresh without interruption for ten new poses
  kCoastOver = 1U << 7U,         ///< 700 ms since kCoast began, or since fresh poses made the error as small as then
  kLevelOver = 1U << 8U,         ///< in kLevel for 1 s, and slow enough for the pilot or there for too long
  kNeutralOver = 1U << 9U,       ///< in kRelease for 0.5 s
  kOperatorEngages = 1U << 10U,  ///< the operator's order to fly is valid
  // Reported only: no row of the table tests the next five. They are in the log's field `facts`.
  kRollModelMismatch = 1U << 11U,  ///< roll no longer follows its model, by sysid::ResidualMonitor; likewise the next
  kPitchModelMismatch = 1U << 12U,
  kYawRateModelMismatch = 1U << 13U,
  kClimbModelMismatch = 1U << 14U,
  kTrimDrifted = 1U << 15U,  ///< in hover, by est::TrimMonitor
  // Tested by rows again, except kLimitCycle.
  kReserveSpent = 1U << 16U,       ///< 500 ms in kCoast, as for kCoastOver, and the predicted error reached the fence
  kOutsideFence = 1U << 17U,       ///< the aircraft is beyond a side, the floor or the ceiling of its fence
  kAuthorityExceeded = 1U << 18U,  ///< for 3 s the wind has been stronger than the aircraft (ControlAuthorityMonitor)
  kTaskFlies = 1U << 19U,          ///< the autopilot takes off or lands by its own task, by the operator's order
  kLimitCycle =
      1U << 20U,  ///< reported only: a limit cycle was detected, and the fallback law flies (ctl::LimitCycleDetector)
  kLimitCyclePersists = 1U << 21U,  ///< acted upon: the limit cycle persists under the fallback law
  kOnGround = 1U << 22U,            ///< "on the ground" in flight for 500 ms, or 250 ms if kEstimateLost
  kFlightFailure = 1U << 23U,       ///< tilt beyond 45 degrees, tumbling, free fall or a crash (FailureDetector)
};
template <>
inline constexpr bool kIsCondition<FailsafeCondition> = true;

/// Why a step was made. A row names its reason; if a condition has several causes, the supervisor finds the right one.
enum class FailsafeReason : std::uint8_t {
  kNone,
  kControlGone,      ///< control or mode F was lost: the link says which
  kGivenBack,        ///< by the operator
  kTelemetrySilent,  ///< no telemetry package for 500 ms
  kCommandInvalid,   ///< the law's command was not finite or far out of range
  kPoseRefused,      ///< the gate refused the poses for 0.3 s, or a check contradicts them or the attitude
  kEstimateLost,     ///< not started, attitude gone, or no pose used for a second
  kPoseOld,
  kTelemetryOld,
  kCoastOver,
  kLevelOver,
  kNeutralOver,
  kRecovered,
  kEngaged,       ///< by the operator
  kReserveSpent,  ///< further coasting might leave the fence
  kFenceLeft,
  kAuthorityExceeded,  ///< the wind is stronger than the aircraft
  kTask,               ///< the autopilot takes off or lands, by the operator's order
  kLimitCycle,         ///< a limit cycle persists even under the fallback law
  kOnGround,           ///< the autopilot's flight status is "on the ground"
  kFlightFailure,      ///< FailureDetector: the observation says which failure
};
inline constexpr std::size_t kFailsafeReasonCount = 21;

std::string_view name(FailsafeState failsafe_state);
std::string_view name(FailsafeReason cause);

/// In `from`, with all of `needs` and none of `excludes`: go to `to`, because of `why`.
struct FailsafeTransition {
  FailsafeState from;
  FailsafeCondition needs;
  FailsafeCondition excludes;
  FailsafeState to;
  FailsafeReason why;
};

/// Read from the top, first match wins; no match: stay. In every state the rows for a loss of control come first.
inline constexpr std::array kFailsafeTransitions{
    // The pilot, the app or a mission took control: stop at once, and never request it again without the operator.
    FailsafeTransition{FailsafeState::kNominal, FailsafeCondition::kNone, FailsafeCondition::kCommandable,
                       FailsafeState::kSilent, FailsafeReason::kControlGone},
    FailsafeTransition{FailsafeState::kCoast, FailsafeCondition::kNone, FailsafeCondition::kCommandable,
                       FailsafeState::kSilent, FailsafeReason::kControlGone},
    FailsafeTransition{FailsafeState::kLevel, FailsafeCondition::kNone, FailsafeCondition::kCommandable,
                       FailsafeState::kSilent, FailsafeReason::kControlGone},
    FailsafeTransition{FailsafeState::kRelease, FailsafeCondition::kNone, FailsafeCondition::kCommandable,
                       FailsafeState::kSilent, FailsafeReason::kControlGone},
    // Nothing of ours helps an aircraft that is out of control or on the ground: the pilot has the sticks at once.
    FailsafeTransition{FailsafeState::kNominal, FailsafeCondition::kFlightFailure, FailsafeCondition::kNone,
                       FailsafeState::kSilent, FailsafeReason::kFlightFailure},
    FailsafeTransition{FailsafeState::kCoast, FailsafeCondition::kFlightFailure, FailsafeCondition::kNone,
                       FailsafeState::kSilent, FailsafeReason::kFlightFailure},
    FailsafeTransition{FailsafeState::kLevel, FailsafeCondition::kFlightFailure, FailsafeCondition::kNone,
                       FailsafeState::kSilent, FailsafeReason::kFlightFailure},
    FailsafeTransition{FailsafeState::kRelease, FailsafeCondition::kFlightFailure, FailsafeCondition::kNone,
                       FailsafeState::kSilent, FailsafeReason::kFlightFailure},
    FailsafeTransition{FailsafeState::kNominal, FailsafeCondition::kOnGround, FailsafeCondition::kTaskFlies,
                       FailsafeState::kSilent, FailsafeReason::kOnGround},
    FailsafeTransition{FailsafeState::kCoast, FailsafeCondition::kOnGround, FailsafeCondition::kTaskFlies,
                       FailsafeState::kSilent, FailsafeReason::kOnGround},
    FailsafeTransition{FailsafeState::kLevel, FailsafeCondition::kOnGround, FailsafeCondition::kTaskFlies,
                       FailsafeState::kSilent, FailsafeReason::kOnGround},
    // From kRelease to kSilent.
    FailsafeTransition{FailsafeState::kRelease, FailsafeCondition::kNeutralOver, FailsafeCondition::kNone,
                       FailsafeState::kSilent, FailsafeReason::kNeutralOver},
    FailsafeTransition{FailsafeState::kNominal, FailsafeCondition::kOperatorReleases, FailsafeCondition::kNone,
                       FailsafeState::kRelease, FailsafeReason::kGivenBack},
    FailsafeTransition{FailsafeState::kCoast, FailsafeCondition::kOperatorReleases, FailsafeCondition::kNone,
                       FailsafeState::kRelease, FailsafeReason::kGivenBack},
    FailsafeTransition{FailsafeState::kLevel, FailsafeCondition::kOperatorReleases, FailsafeCondition::kNone,
                       FailsafeState::kRelease, FailsafeReason::kGivenBack},
    FailsafeTransition{FailsafeState::kNominal, FailsafeCondition::kTelemetryDead, FailsafeCondition::kNone,
                       FailsafeState::kRelease, FailsafeReason::kTelemetrySilent},
    FailsafeTransition{FailsafeState::kCoast, FailsafeCondition::kTelemetryDead, FailsafeCondition::kNone,
                       FailsafeState::kRelease, FailsafeReason::kTelemetrySilent},
    FailsafeTransition{FailsafeState::kLevel, FailsafeCondition::kTelemetryDead, FailsafeCondition::kNone,
                       FailsafeState::kRelease, FailsafeReason::kTelemetrySilent},
    // An order to fly that can be obeyed is obeyed even at the last moment; one that cannot does not delay the pilot.
    FailsafeTransition{FailsafeState::kLevel, FailsafeCondition::kOperatorEngages | FailsafeCondition::kRecovered,
                       FailsafeCondition::kEstimateLost | FailsafeCondition::kCommandInvalid |
                           FailsafeCondition::kOutsideFence | FailsafeCondition::kTaskFlies,
                       FailsafeState::kNominal, FailsafeReason::kEngaged},
    FailsafeTransition{FailsafeState::kLevel, FailsafeCondition::kLevelOver, FailsafeCondition::kNone,
                       FailsafeState::kRelease, FailsafeReason::kLevelOver},
    // While the autopilot flies its own task the law is inactive, because the task needs no pose.
    FailsafeTransition{FailsafeState::kNominal, FailsafeCondition::kTaskFlies, FailsafeCondition::kNone,
                       FailsafeState::kLevel, FailsafeReason::kTask},
    FailsafeTransition{FailsafeState::kCoast, FailsafeCondition::kTaskFlies, FailsafeCondition::kNone,
                       FailsafeState::kLevel, FailsafeReason::kTask},
    FailsafeTransition{
        FailsafeState::kSilent, FailsafeCondition::kTaskFlies | FailsafeCondition::kCommandable,
        FailsafeCondition::kOperatorReleases | FailsafeCondition::kTelemetryDead | FailsafeCondition::kFlightFailure,
        FailsafeState::kLevel, FailsafeReason::kTask},
    // Down to kLevel, or from kNominal to kCoast.
    FailsafeTransition{FailsafeState::kNominal, FailsafeCondition::kCommandInvalid, FailsafeCondition::kNone,
                       FailsafeState::kLevel, FailsafeReason::kCommandInvalid},
    FailsafeTransition{FailsafeState::kCoast, FailsafeCondition::kCommandInvalid, FailsafeCondition::kNone,
                       FailsafeState::kLevel, FailsafeReason::kCommandInvalid},
    FailsafeTransition{FailsafeState::kNominal, FailsafeCondition::kEstimateLost, FailsafeCondition::kNone,
                       FailsafeState::kLevel, FailsafeReason::kEstimateLost},
    FailsafeTransition{FailsafeState::kCoast, FailsafeCondition::kEstimateLost, FailsafeCondition::kNone,
                       FailsafeState::kLevel, FailsafeReason::kEstimateLost},
    FailsafeTransition{FailsafeState::kNominal, FailsafeCondition::kOutsideFence, FailsafeCondition::kNone,
                       FailsafeState::kLevel, FailsafeReason::kFenceLeft},
    FailsafeTransition{FailsafeState::kCoast, FailsafeCondition::kOutsideFence, FailsafeCondition::kNone,
                       FailsafeState::kLevel, FailsafeReason::kFenceLeft},
    FailsafeTransition{FailsafeState::kNominal, FailsafeCondition::kAuthorityExceeded, FailsafeCondition::kNone,
                       FailsafeState::kLevel, FailsafeReason::kAuthorityExceeded},
    FailsafeTransition{FailsafeState::kNominal, FailsafeCondition::kLimitCyclePersists, FailsafeCondition::kNone,
                       FailsafeState::kLevel, FailsafeReason::kLimitCycle},
    FailsafeTransition{FailsafeState::kCoast, FailsafeCondition::kReserveSpent, FailsafeCondition::kFresh,
                       FailsafeState::kLevel, FailsafeReason::kReserveSpent},
    FailsafeTransition{FailsafeState::kCoast, FailsafeCondition::kCoastOver, FailsafeCondition::kFresh,
                       FailsafeState::kLevel, FailsafeReason::kCoastOver},
    FailsafeTransition{FailsafeState::kNominal, FailsafeCondition::kNone, FailsafeCondition::kFresh,
                       FailsafeState::kCoast, FailsafeReason::kPoseOld},
    // Up again: from kCoast by itself, from kLevel (above) and kSilent only by the operator.
    FailsafeTransition{FailsafeState::kCoast, FailsafeCondition::kRecovered, FailsafeCondition::kNone,
                       FailsafeState::kNominal, FailsafeReason::kRecovered},
    FailsafeTransition{
        FailsafeState::kSilent,
        FailsafeCondition::kOperatorEngages | FailsafeCondition::kCommandable | FailsafeCondition::kRecovered,
        FailsafeCondition::kEstimateLost | FailsafeCondition::kCommandInvalid | FailsafeCondition::kOperatorReleases |
            FailsafeCondition::kTelemetryDead | FailsafeCondition::kOutsideFence | FailsafeCondition::kOnGround |
            FailsafeCondition::kFlightFailure,
        FailsafeState::kNominal, FailsafeReason::kEngaged},
};

/// Number of the first row that matches; the table's size if none does.
constexpr std::size_t row_number(FailsafeState state, FailsafeCondition conditions) {
  return first_row(kFailsafeTransitions, [state, conditions](const FailsafeTransition& row) {
    return row.from == state && all(conditions, row.needs) && !any(conditions, row.excludes);
  });
}

/// The state after one look-up in the table.
constexpr FailsafeState next_failsafe_state(FailsafeState state, FailsafeCondition conditions) {
  const std::size_t number = row_number(state, conditions);
  return number < kFailsafeTransitions.size() ? kFailsafeTransitions[number].to : state;
}

/// Whether the law's command may leave in this state. (In kCoast that of kLevel may leave instead.)
constexpr bool passes_law(FailsafeState state) {
  return state == FailsafeState::kNominal || state == FailsafeState::kCoast;
}
constexpr bool may_transmit(FailsafeState state) { return state != FailsafeState::kSilent; }

static_assert(next_failsafe_state(FailsafeState::kNominal, FailsafeCondition::kFresh | FailsafeCondition::kRecovered) ==
                  FailsafeState::kSilent,
              "the pilot comes first");
static_assert(next_failsafe_state(FailsafeState::kNominal, FailsafeCondition::kCommandable |
                                                               FailsafeCondition::kFresh) == FailsafeState::kNominal);
static_assert(next_failsafe_state(FailsafeState::kNominal, FailsafeCondition::kCommandable) == FailsafeState::kCoast);
static_assert(next_failsafe_state(FailsafeState::kCoast, FailsafeCondition::kCommandable |
                                                             FailsafeCondition::kCoastOver) == FailsafeState::kLevel);
static_assert(next_failsafe_state(FailsafeState::kCoast, FailsafeCondition::kCommandable |
                                                             FailsafeCondition::kCoastOver |
                                                             FailsafeCondition::kFresh) == FailsafeState::kCoast,
              "poses are back: ten of them decide");
static_assert(next_failsafe_state(FailsafeState::kLevel, FailsafeCondition::kCommandable | FailsafeCondition::kFresh |
                                                             FailsafeCondition::kRecovered) == FailsafeState::kLevel,
              "from level back only by the operator");
static_assert(next_failsafe_state(FailsafeState::kSilent, FailsafeCondition::kCommandable | FailsafeCondition::kFresh |
                                                              FailsafeCondition::kRecovered) == FailsafeState::kSilent,
              "nobody flies unasked");
static_assert(next_failsafe_state(FailsafeState::kLevel, FailsafeCondition::kTaskFlies) == FailsafeState::kSilent,
              "the pilot ends a task, too");
static_assert(next_failsafe_state(FailsafeState::kLevel,
                                  FailsafeCondition::kCommandable | FailsafeCondition::kTaskFlies |
                                      FailsafeCondition::kOperatorReleases) == FailsafeState::kRelease);
static_assert(next_failsafe_state(FailsafeState::kSilent,
                                  FailsafeCondition::kCommandable | FailsafeCondition::kTaskFlies |
                                      FailsafeCondition::kRecovered | FailsafeCondition::kOperatorEngages) ==
                  FailsafeState::kLevel,
              "the law waits for the end of a take-off");

}  // namespace m100::safety
