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
  kEstimateLost = 1U << 4U,      ///< poses refused for 0.3 s or contradicted, not Estimate::healthy, or vibration
  kFresh = 1U << 5U,             ///< the pose is at most fresh_limit() old, and telemetry at most 100 ms
  kRecovered = 1U << 6U,         ///< kFresh without interruption for ten new poses
  kCoastOver = 1U << 7U,    ///< 700 ms in kCoast; restarts when fresh poses make the error as small as at its beginning
  kLevelOver = 1U << 8U,    ///< in kLevel for 1 s, and slow enough for the pilot or there for too long
  kNeutralOver = 1U << 9U,  ///< in kRelease for 0.5 s
  kOperatorEngages = 1U << 10U,  ///< the operator's order to fly is valid
  // Reported only: no row of the table tests the next five. They are in the log's field `facts`.
  kRollModelMismatch = 1U << 11U,  ///< roll no longer follows its model, by sysid::ResidualMonitor; likewise the next
  kPitchModelMismatch = 1U << 12U,
  kYawRateModelMismatch = 1U << 13U,
  kClimbModelMismatch = 1U << 14U,
  kTrimDrifted = 1U << 15U,  ///< in hover, by est::TrimMonitor
  // Tested by rows again, except kLimitCycle.
  kReserveSpent = 1U << 16U,  ///< 500 ms in kCoast, timed as for kCoastOver, and the predicted error reached the fence
  kOutsideFence = 1U << 17U,  ///< the aircraft is beyond a side, the floor or the ceiling of its fence
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
  kVibration,          ///< vibration hides a false pose from the check of the force
};
inline constexpr std::size_t kFailsafeReasonCount = 22;

std::string_view name(FailsafeState failsafe_state);
std::string_view name(FailsafeReason cause);

/// A row of the table: in `from`, with all of `needs` and none of `excludes`, go to `to` because of `why`.
struct FailsafeTransition {
  FailsafeState from;
  FailsafeCondition needs;
  FailsafeCondition excludes;
  FailsafeState to;
  FailsafeReason why;
};

/// Read from the top, first match wins; no match: stay. In every state the rows for a loss of control come first.
inline constexpr std::array kFailsafeTransitions = [] {
  using Row = FailsafeTransition;
  using In = FailsafeState;
  using When = FailsafeCondition;
  using Why = FailsafeReason;
  return std::array{
      // The pilot, the app or a mission took control: stop at once, and never request it again without the operator.
      Row{In::kNominal, When::kNone, When::kCommandable, In::kSilent, Why::kControlGone},
      Row{In::kCoast, When::kNone, When::kCommandable, In::kSilent, Why::kControlGone},
      Row{In::kLevel, When::kNone, When::kCommandable, In::kSilent, Why::kControlGone},
      Row{In::kRelease, When::kNone, When::kCommandable, In::kSilent, Why::kControlGone},
      // Nothing of ours helps an aircraft that is out of control or on the ground: the pilot has the sticks at once.
      Row{In::kNominal, When::kFlightFailure, When::kNone, In::kSilent, Why::kFlightFailure},
      Row{In::kCoast, When::kFlightFailure, When::kNone, In::kSilent, Why::kFlightFailure},
      Row{In::kLevel, When::kFlightFailure, When::kNone, In::kSilent, Why::kFlightFailure},
      Row{In::kRelease, When::kFlightFailure, When::kNone, In::kSilent, Why::kFlightFailure},
      Row{In::kNominal, When::kOnGround, When::kTaskFlies, In::kSilent, Why::kOnGround},
      Row{In::kCoast, When::kOnGround, When::kTaskFlies, In::kSilent, Why::kOnGround},
      Row{In::kLevel, When::kOnGround, When::kTaskFlies, In::kSilent, Why::kOnGround},
      // Out of kRelease when its time is over. Into kRelease when the operator gives control back or telemetry is
      // silent.
      Row{In::kRelease, When::kNeutralOver, When::kNone, In::kSilent, Why::kNeutralOver},
      Row{In::kNominal, When::kOperatorReleases, When::kNone, In::kRelease, Why::kGivenBack},
      Row{In::kCoast, When::kOperatorReleases, When::kNone, In::kRelease, Why::kGivenBack},
      Row{In::kLevel, When::kOperatorReleases, When::kNone, In::kRelease, Why::kGivenBack},
      Row{In::kNominal, When::kTelemetryDead, When::kNone, In::kRelease, Why::kTelemetrySilent},
      Row{In::kCoast, When::kTelemetryDead, When::kNone, In::kRelease, Why::kTelemetrySilent},
      Row{In::kLevel, When::kTelemetryDead, When::kNone, In::kRelease, Why::kTelemetrySilent},
      // In kLevel an order to fly that can be obeyed has priority over the end of kLevel.
      Row{In::kLevel, When::kOperatorEngages | When::kRecovered,
          When::kEstimateLost | When::kCommandInvalid | When::kOutsideFence | When::kTaskFlies, In::kNominal,
          Why::kEngaged},
      Row{In::kLevel, When::kLevelOver, When::kNone, In::kRelease, Why::kLevelOver},
      // While the autopilot flies its own task the law is inactive, because the task needs no pose.
      Row{In::kNominal, When::kTaskFlies, When::kNone, In::kLevel, Why::kTask},
      Row{In::kCoast, When::kTaskFlies, When::kNone, In::kLevel, Why::kTask},
      Row{In::kSilent, When::kTaskFlies | When::kCommandable,
          When::kOperatorReleases | When::kTelemetryDead | When::kFlightFailure, In::kLevel, Why::kTask},
      // Down to kLevel, or from kNominal to kCoast.
      Row{In::kNominal, When::kCommandInvalid, When::kNone, In::kLevel, Why::kCommandInvalid},
      Row{In::kCoast, When::kCommandInvalid, When::kNone, In::kLevel, Why::kCommandInvalid},
      Row{In::kNominal, When::kEstimateLost, When::kNone, In::kLevel, Why::kEstimateLost},
      Row{In::kCoast, When::kEstimateLost, When::kNone, In::kLevel, Why::kEstimateLost},
      Row{In::kNominal, When::kOutsideFence, When::kNone, In::kLevel, Why::kFenceLeft},
      Row{In::kCoast, When::kOutsideFence, When::kNone, In::kLevel, Why::kFenceLeft},
      Row{In::kNominal, When::kAuthorityExceeded, When::kNone, In::kLevel, Why::kAuthorityExceeded},
      Row{In::kNominal, When::kLimitCyclePersists, When::kNone, In::kLevel, Why::kLimitCycle},
      Row{In::kCoast, When::kReserveSpent, When::kFresh, In::kLevel, Why::kReserveSpent},
      Row{In::kCoast, When::kCoastOver, When::kFresh, In::kLevel, Why::kCoastOver},
      Row{In::kNominal, When::kNone, When::kFresh, In::kCoast, Why::kPoseOld},
      // Up again: from kCoast by itself, from kLevel (above) and kSilent only by the operator.
      Row{In::kCoast, When::kRecovered, When::kNone, In::kNominal, Why::kRecovered},
      Row{In::kSilent, When::kOperatorEngages | When::kCommandable | When::kRecovered,
          When::kEstimateLost | When::kCommandInvalid | When::kOperatorReleases | When::kTelemetryDead |
              When::kOutsideFence | When::kOnGround | When::kFlightFailure,
          In::kNominal, Why::kEngaged},
  };
}();

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

namespace failsafe_checks {

using S = FailsafeState;
using enum FailsafeCondition;

static_assert(next_failsafe_state(S::kNominal, kFresh | kRecovered) == S::kSilent, "the pilot comes first");
static_assert(next_failsafe_state(S::kNominal, kCommandable | kFresh) == S::kNominal);
static_assert(next_failsafe_state(S::kNominal, kCommandable) == S::kCoast);
static_assert(next_failsafe_state(S::kCoast, kCommandable | kCoastOver) == S::kLevel);
static_assert(next_failsafe_state(S::kCoast, kCommandable | kCoastOver | kFresh) == S::kCoast,
              "poses are back: ten of them decide");
static_assert(next_failsafe_state(S::kLevel, kCommandable | kFresh | kRecovered) == S::kLevel,
              "from level back only by the operator");
static_assert(next_failsafe_state(S::kSilent, kCommandable | kFresh | kRecovered) == S::kSilent,
              "nobody flies unasked");
static_assert(next_failsafe_state(S::kLevel, kTaskFlies) == S::kSilent, "the pilot ends a task, too");
static_assert(next_failsafe_state(S::kLevel, kCommandable | kTaskFlies | kOperatorReleases) == S::kRelease);
static_assert(next_failsafe_state(S::kSilent, kCommandable | kTaskFlies | kRecovered | kOperatorEngages) == S::kLevel,
              "the law waits for the end of a take-off");

}  // namespace failsafe_checks
}  // namespace m100::safety
