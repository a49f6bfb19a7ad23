// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

namespace m100::safety {

/// The failsafe ladder, from the top down. What each state lets through:
///   kNominal  the law's command
///   kCoast    the law's command, computed from the model's prediction, for a stated time
///   kLevel    level attitude, no climb, no turn: the autopilot holds the height
///   kRelease  the same, and control is about to be given back
///   kSilent   nothing: not ours to command
enum class Rung : std::uint8_t { kSilent, kNominal, kCoast, kLevel, kRelease };

/// What the table looks at, each a sign of something; a set is a bit mask.
enum class Sign : std::uint16_t {
  kNone = 0,
  kCommandable = 1U << 0U,       ///< authority is ours and the mode switch stands at F
  kOperatorReleases = 1U << 1U,  ///< given back on purpose
  kTelemetryDead = 1U << 2U,     ///< the autopilot has been silent for 500 ms
  kCommandUnsound = 1U << 3U,    ///< the law's command is not finite or far out of range
  kEstimateLost = 1U << 4U,      ///< gate shut for 5 poses, or covariance beyond its limit
  kFresh = 1U << 5U,             ///< pose younger than 60 ms and telemetry than 100 ms
  kRecovered = 1U << 6U,         ///< fresh for 10 ticks in a row
  kCoastOver = 1U << 7U,         ///< in kCoast for 200 ms
  kLevelOver = 1U << 8U,         ///< in kLevel for 1 s
  kNeutralOver = 1U << 9U,       ///< in kRelease for 0.5 s
  kOperatorEngages = 1U << 10U,  ///< asked to fly, by a person
  // Told, not acted upon: no row of the table asks for these. They stand in the log's `facts`.
  kRollLeftModel = 1U << 11U,   ///< the axis answers unlike its model, by the residual monitor; likewise below
  kPitchLeftModel = 1U << 12U,  ///< in the order of sysid::Channel
  kYawRateLeftModel = 1U << 13U,
  kClimbLeftModel = 1U << 14U,
  kTrimDrifted = 1U << 15U,  ///< in hover, by est::TrimWatch
};
constexpr Sign operator|(Sign a, Sign b) {
  return static_cast<Sign>(static_cast<std::uint16_t>(a) | static_cast<std::uint16_t>(b));
}
constexpr bool has_all(Sign set, Sign asked) {
  return (static_cast<std::uint16_t>(set) & static_cast<std::uint16_t>(asked)) == static_cast<std::uint16_t>(asked);
}
constexpr bool has_any(Sign set, Sign asked) {
  return (static_cast<std::uint16_t>(set) & static_cast<std::uint16_t>(asked)) != 0;
}

/// In `from`, with all of `needs` and none of `excludes`: go to `to`.
struct Transition {
  Rung from;
  Sign needs;
  Sign excludes;
  Rung to;
};

/// Read from the top, first match wins; no match: stay. Rows that take authority away come first in every state.
inline constexpr std::array kTransitions{
    // The pilot, or whoever took control: stop at once, and never ask again by ourselves.
    Transition{Rung::kNominal, Sign::kNone, Sign::kCommandable, Rung::kSilent},
    Transition{Rung::kCoast, Sign::kNone, Sign::kCommandable, Rung::kSilent},
    Transition{Rung::kLevel, Sign::kNone, Sign::kCommandable, Rung::kSilent},
    Transition{Rung::kRelease, Sign::kNone, Sign::kCommandable, Rung::kSilent},
    // The way out.
    Transition{Rung::kRelease, Sign::kNeutralOver, Sign::kNone, Rung::kSilent},
    Transition{Rung::kNominal, Sign::kOperatorReleases, Sign::kNone, Rung::kRelease},
    Transition{Rung::kCoast, Sign::kOperatorReleases, Sign::kNone, Rung::kRelease},
    Transition{Rung::kLevel, Sign::kOperatorReleases, Sign::kNone, Rung::kRelease},
    Transition{Rung::kNominal, Sign::kTelemetryDead, Sign::kNone, Rung::kRelease},
    Transition{Rung::kCoast, Sign::kTelemetryDead, Sign::kNone, Rung::kRelease},
    Transition{Rung::kLevel, Sign::kTelemetryDead, Sign::kNone, Rung::kRelease},
    Transition{Rung::kLevel, Sign::kLevelOver, Sign::kOperatorEngages, Rung::kRelease},
    // Down one step.
    Transition{Rung::kNominal, Sign::kCommandUnsound, Sign::kNone, Rung::kLevel},
    Transition{Rung::kCoast, Sign::kCommandUnsound, Sign::kNone, Rung::kLevel},
    Transition{Rung::kNominal, Sign::kEstimateLost, Sign::kNone, Rung::kLevel},
    Transition{Rung::kCoast, Sign::kEstimateLost, Sign::kNone, Rung::kLevel},
    Transition{Rung::kCoast, Sign::kCoastOver, Sign::kFresh, Rung::kLevel},
    Transition{Rung::kNominal, Sign::kNone, Sign::kFresh, Rung::kCoast},
    // Up again: from kCoast by itself, from kLevel and kSilent only by the operator.
    Transition{Rung::kCoast, Sign::kRecovered, Sign::kNone, Rung::kNominal},
    Transition{Rung::kLevel, Sign::kOperatorEngages | Sign::kRecovered, Sign::kEstimateLost | Sign::kCommandUnsound,
               Rung::kNominal},
    Transition{Rung::kSilent, Sign::kOperatorEngages | Sign::kCommandable | Sign::kRecovered,
               Sign::kEstimateLost | Sign::kCommandUnsound | Sign::kOperatorReleases | Sign::kTelemetryDead,
               Rung::kNominal},
};

/// One look at the table.
constexpr Rung next_rung(Rung state, Sign facts) {
  for (const Transition& row : kTransitions) {
    if (row.from == state && has_all(facts, row.needs) && !has_any(facts, row.excludes)) {
      return row.to;
    }
  }
  return state;
}

/// The largest thing the law's command may reach in this state.
constexpr bool passes_law(Rung state) { return state == Rung::kNominal || state == Rung::kCoast; }
constexpr bool may_transmit(Rung state) { return state != Rung::kSilent; }

static_assert(next_rung(Rung::kNominal, Sign::kFresh | Sign::kRecovered) == Rung::kSilent, "the pilot comes first");
static_assert(next_rung(Rung::kNominal, Sign::kCommandable | Sign::kFresh) == Rung::kNominal);
static_assert(next_rung(Rung::kNominal, Sign::kCommandable) == Rung::kCoast);
static_assert(next_rung(Rung::kCoast, Sign::kCommandable | Sign::kCoastOver) == Rung::kLevel);
static_assert(next_rung(Rung::kCoast, Sign::kCommandable | Sign::kCoastOver | Sign::kFresh) == Rung::kCoast,
              "poses are back: ten of them decide");
static_assert(next_rung(Rung::kLevel, Sign::kCommandable | Sign::kFresh | Sign::kRecovered) == Rung::kLevel,
              "from level back only by the operator");
static_assert(next_rung(Rung::kSilent, Sign::kCommandable | Sign::kFresh | Sign::kRecovered) == Rung::kSilent,
              "nobody flies unasked");

}  // namespace m100::safety
