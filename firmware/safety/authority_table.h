// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware/safety/authority.h"
#include "firmware/safety/rows.h"

namespace m100::safety {

/// A set of stages, so that one row can speak for several.
struct StageSet {
  std::uint32_t bits = 0;
  constexpr StageSet() = default;
  constexpr StageSet(Stage stage) : bits(1U << static_cast<unsigned>(stage)) {}  // NOLINT: a stage is a set of one
  constexpr bool has(Stage stage) const { return (bits >> static_cast<unsigned>(stage) & 1U) != 0; }
  friend constexpr StageSet operator|(StageSet a, StageSet b) {
    a.bits |= b.bits;
    return a;
  }
};
constexpr StageSet operator|(Stage a, Stage b) { return StageSet(a) | StageSet(b); }

struct AuthorityRow {
  StageSet from;
  AuthoritySign with;     ///< all of them
  AuthoritySign without;  ///< none of them
  Stage to;
  Action action;
  Reason reason;
};

inline constexpr StageSet kStartUp = Stage::kAskingVersion | Stage::kActivating | Stage::kSettingRates;
inline constexpr StageSet kIdle = Stage::kAwaitingTelemetry | Stage::kReady | Stage::kSilent;
inline constexpr StageSet kAcquiring = Stage::kObtaining | Stage::kSpacing | Stage::kConfirming | Stage::kEnabling;
inline constexpr StageSet kHolding = Stage::kInControl | Stage::kReleasing;
inline constexpr StageSet kEveryStage =
    kStartUp | kIdle | kAcquiring | kHolding | Stage::kListening | Stage::kPausing | Stage::kSilentCold;

/// Read from top to bottom, the first row that matches wins. If no row matches, the stage stays.
inline constexpr auto kAuthorityTable = [] {
  using enum AuthoritySign;
  using S = Stage;
  using A = Action;
  using R = Reason;
  return std::array{
      // Loss of authority is tested before anything else. Control that is still ours then is given back by step().
      AuthorityRow{kEveryStage, kPortBack, kNone, S::kListening, A::kNone, R::kPortBack},
      AuthorityRow{kAcquiring | kHolding, kOwnStall, kNone, S::kSilent, A::kReleaseControl, R::kOwnStall},
      AuthorityRow{kAcquiring | kHolding | kIdle, kRestarted, kNone, S::kSilentCold, A::kNone, R::kRestarted},
      AuthorityRow{kStartUp | S::kPausing, kRestarted, kNone, S::kListening, A::kNone, R::kRestarted},
      AuthorityRow{kAcquiring | kHolding, kLostPush, kNone, S::kSilent, A::kNone, R::kControlLost},
      AuthorityRow{kAcquiring | kHolding | kIdle, kNone, kHeard, S::kSilentCold, A::kNone, R::kLinkSilent},
      AuthorityRow{kAcquiring | kHolding, kNone, kItemsFresh, S::kSilentCold, A::kNone, R::kLinkSilent},
      AuthorityRow{kAcquiring | kHolding, kNone, kModeF, S::kSilent, A::kNone, R::kLeftModeF},
      AuthorityRow{S::kEnabling | S::kInControl, kNone, kDeviceOurs, S::kSilent, A::kNone, R::kTaken},
      AuthorityRow{S::kInControl, kNeedsVirtualRc, kVirtualRcOn, S::kSilent, A::kNone, R::kVirtualRcEnded},
      AuthorityRow{S::kInControl, kNoAnswer, kNone, S::kSilent, A::kReleaseControl, R::kUnheard},

      // The operator gives control back.
      AuthorityRow{kAcquiring | S::kInControl, kReleaseAsked, kNone, S::kReleasing, A::kReleaseControl, R::kNone},
      AuthorityRow{S::kReleasing, kNone, kOwed, S::kReady, A::kNone, R::kReleased},

      // Start-up, by itself, until the first loss.
      AuthorityRow{S::kListening, kHeard, kNone, S::kAskingVersion, A::kAskVersion, R::kStarting},
      AuthorityRow{S::kListening, kTimeOver, kNone, S::kAskingVersion, A::kAskVersion, R::kNothingHeard},
      AuthorityRow{S::kAskingVersion, kDone, kNone, S::kActivating, A::kActivate, R::kStarting},
      AuthorityRow{S::kAskingVersion, kNoAnswer, kHeard, S::kPausing, A::kNone, R::kNothingHeard},
      AuthorityRow{S::kActivating, kDone, kNone, S::kSettingRates, A::kSetRates, R::kStarting},
      AuthorityRow{S::kSettingRates, kDone, kNone, S::kAwaitingTelemetry, A::kNone, R::kStarting},
      AuthorityRow{kStartUp, kRetry, kNone, S::kPausing, A::kNone, R::kAnswer},
      AuthorityRow{kStartUp, kNoAnswer, kNone, S::kPausing, A::kNone, R::kNoAnswer},
      AuthorityRow{kStartUp, kAgain, kNone, S::kPausing, A::kNone, R::kAnswer},
      AuthorityRow{kStartUp, kRefused, kNone, S::kSilentCold, A::kNone, R::kAnswer},
      AuthorityRow{kStartUp, kNotActivated, kNone, S::kPausing, A::kNone, R::kNotActivated},
      AuthorityRow{S::kPausing, kTimeOver, kNone, S::kListening, A::kNone, R::kStarting},
      AuthorityRow{S::kAwaitingTelemetry, kItemsFresh, kNone, S::kReady, A::kNone, R::kNone},
      AuthorityRow{S::kAwaitingTelemetry, kTimeOver, kNone, S::kAwaitingTelemetry, A::kNone, R::kNoRcItem},

      // The operator asks.
      AuthorityRow{S::kSilentCold, kAsked, kNone, S::kListening, A::kNone, R::kStarting},
      AuthorityRow{S::kSilent, kAsked, kNone, S::kAwaitingTelemetry, A::kNone, R::kStarting},
      AuthorityRow{S::kReady, kNone, kItemsFresh, S::kAwaitingTelemetry, A::kNone, R::kNoRcItem},
      AuthorityRow{S::kReady, kAsked | kRcOff, kNone, S::kReady, A::kNone, R::kRcOff},
      AuthorityRow{S::kReady, kAsked, kModeF, S::kReady, A::kNone, R::kNotModeF},
      AuthorityRow{S::kReady, kAsked | kSpaced, kOwed, S::kObtaining, A::kRequestControl, R::kStarting},

      // Every request has to be sent twice: the first is answered "again" (protocol, 6.1). Telemetry may show that
      // control is ours before the answer does, or instead of it.
      AuthorityRow{S::kObtaining | S::kSpacing, kDeviceOurs, kNone, S::kConfirming, A::kNone, R::kGranted},
      AuthorityRow{S::kObtaining, kDone, kNone, S::kConfirming, A::kNone, R::kGranted},
      AuthorityRow{S::kObtaining, kAgain | kTriesLeft, kNone, S::kSpacing, A::kNone, R::kStarting},
      AuthorityRow{S::kObtaining, kNoAnswer | kTriesLeft, kNone, S::kSpacing, A::kNone, R::kNoAnswer},
      AuthorityRow{S::kObtaining, kAgain, kNone, S::kSilent, A::kNone, R::kEndlessObtaining},
      AuthorityRow{S::kObtaining, kNoAnswer, kNone, S::kSilent, A::kNone, R::kNoAnswer},
      AuthorityRow{S::kObtaining, kRetry, kNone, S::kSilent, A::kNone, R::kAnswer},
      AuthorityRow{S::kObtaining, kRefused, kNone, S::kSilent, A::kNone, R::kAnswer},
      AuthorityRow{S::kObtaining, kNotActivated, kNone, S::kSilentCold, A::kNone, R::kNotActivated},
      AuthorityRow{S::kSpacing, kSpaced, kNone, S::kObtaining, A::kRequestControl, R::kStarting},
      AuthorityRow{S::kConfirming, kDeviceOurs, kNeedsVirtualRc, S::kInControl, A::kNone, R::kGranted},
      AuthorityRow{S::kConfirming, kDeviceOurs | kSwitchSpaced, kNone, S::kEnabling, A::kSwitchVirtualRcOn,
                   R::kGranted},
      AuthorityRow{S::kConfirming, kTimeOver, kDeviceOurs, S::kSilent, A::kReleaseControl, R::kNotConfirmed},
      AuthorityRow{S::kEnabling, kVirtualRcOn, kNone, S::kInControl, A::kNone, R::kGranted},
      AuthorityRow{S::kEnabling, kTimeOver | kSwitchesLeft, kNone, S::kConfirming, A::kNone, R::kGranted},
      AuthorityRow{S::kEnabling, kTimeOver, kNone, S::kSilent, A::kReleaseControl, R::kVirtualRcRefused},
  };
}();

/// The most rows that one stage has.
inline constexpr std::size_t kMostRowsOfStage = [] {
  std::array<std::size_t, kStageCount> rows{};
  std::size_t most = 0;
  for (std::size_t stage = 0; stage < kStageCount; ++stage) {
    for (const AuthorityRow& row : kAuthorityTable) {
      rows[stage] += row.from.has(static_cast<Stage>(stage)) ? 1U : 0U;
    }
    most = rows[stage] > most ? rows[stage] : most;
  }
  return most;
}();

/// The rows of each stage by number, in the order of the table, followed by the table's size. A pass over the whole
/// table in every tick would cost more than everything else here.
inline constexpr auto kRowsOfStage = [] {
  std::array<std::array<std::uint8_t, kMostRowsOfStage + 1>, kStageCount> rows{};
  for (std::size_t stage = 0; stage < kStageCount; ++stage) {
    std::size_t count = 0;
    for (std::size_t number = 0; number < kAuthorityTable.size(); ++number) {
      if (kAuthorityTable[number].from.has(static_cast<Stage>(stage))) {
        rows[stage][count++] = static_cast<std::uint8_t>(number);
      }
    }
    rows[stage][count] = static_cast<std::uint8_t>(kAuthorityTable.size());
  }
  return rows;
}();
static_assert(kAuthorityTable.size() < 256);

/// Number of the first row that matches; the table's size if none does.
constexpr std::size_t match_number(Stage stage, AuthoritySign signs) {
  for (const std::uint8_t number : kRowsOfStage[static_cast<std::size_t>(stage)]) {
    if (number == kAuthorityTable.size()) {
      break;
    }
    const AuthorityRow& row = kAuthorityTable[number];
    if (all(signs, row.with) && !any(signs, row.without) && is_on<AuthorityRow>(number)) {
      return number;
    }
  }
  return kAuthorityTable.size();
}

/// The row that matches, or null.
constexpr const AuthorityRow* match(Stage stage, AuthoritySign signs) {
  const std::size_t number = match_number(stage, signs);
  return number < kAuthorityTable.size() ? &kAuthorityTable[number] : nullptr;
}

/// The stage after one step. By number: GCC's sanitizers do not let a constant expression compare addresses.
constexpr Stage next(Stage stage, AuthoritySign signs) {
  const std::size_t number = match_number(stage, signs);
  return number < kAuthorityTable.size() ? kAuthorityTable[number].to : stage;
}

namespace checks {

using enum AuthoritySign;
/// All is well in flight, over Virtual RC.
inline constexpr AuthoritySign kFlying = kHeard | kItemsFresh | kModeF | kDeviceOurs | kVirtualRcOn | kNeedsVirtualRc;

constexpr AuthoritySign except(AuthoritySign signs, AuthoritySign gone) { return signs & ~gone; }

static_assert(next(Stage::kInControl, kFlying) == Stage::kInControl);
static_assert(next(Stage::kInControl, except(kFlying, kModeF)) == Stage::kSilent);
static_assert(next(Stage::kInControl, except(kFlying, kDeviceOurs)) == Stage::kSilent);
static_assert(next(Stage::kInControl, except(kFlying, kVirtualRcOn)) == Stage::kSilent);
static_assert(next(Stage::kInControl, except(kFlying, kItemsFresh)) == Stage::kSilentCold);
static_assert(next(Stage::kInControl, except(kFlying, kHeard)) == Stage::kSilentCold);
static_assert(next(Stage::kInControl, kFlying | kLostPush | kReleaseAsked) == Stage::kSilent, "loss before wishes");
static_assert(next(Stage::kInControl, kFlying | kRestarted | kLostPush) == Stage::kSilentCold);
static_assert(next(Stage::kInControl, except(kFlying, kVirtualRcOn | kNeedsVirtualRc)) == Stage::kInControl,
              "the movement channel does not need Virtual RC");
static_assert(next(Stage::kSilent, kFlying | kSpaced | kTriesLeft | kDone) == Stage::kSilent, "never by itself");
static_assert(next(Stage::kSilentCold, kFlying | kSpaced | kTriesLeft | kDone) == Stage::kSilentCold);
static_assert(next(Stage::kReady, kFlying | kSpaced | kTriesLeft) == Stage::kReady, "not unasked");
static_assert(next(Stage::kReady, kFlying | kAsked) == Stage::kReady, "not before two seconds have passed");
static_assert(next(Stage::kReady, kFlying | kAsked | kSpaced) == Stage::kObtaining);
static_assert(next(Stage::kReady, kFlying | kAsked | kSpaced | kOwed) == Stage::kReady, "first it is given back");
static_assert(next(Stage::kReleasing, kFlying | kOwed | kDone) == Stage::kReleasing,
              "telemetry decides, not an answer");
static_assert(next(Stage::kInControl, kFlying | kOwnStall) == Stage::kSilent);
static_assert(next(Stage::kInControl, kFlying | kNoAnswer) == Stage::kSilent, "nobody hears us");
static_assert(next(Stage::kInControl, kFlying | kPortBack) == Stage::kListening);
static_assert(next(Stage::kSilentCold, kFlying | kPortBack) == Stage::kListening);
static_assert(kAuthorityTable[match_number(Stage::kReady, except(kFlying, kModeF) | kAsked | kSpaced)].reason ==
              Reason::kNotModeF);
static_assert(next(Stage::kObtaining, except(kFlying, kDeviceOurs) | kAgain) == Stage::kSilent,
              "someone else holds control");
static_assert(next(Stage::kObtaining, except(kFlying, kDeviceOurs) | kAgain | kTriesLeft) == Stage::kSpacing);
static_assert(next(Stage::kObtaining, kFlying | kNoAnswer) == Stage::kConfirming, "telemetry says that it is granted");

/// Every row that leads to a stage in which commands may leave requires the proof in telemetry.
constexpr bool control_needs_proof() {
  for (const AuthorityRow& row : kAuthorityTable) {
    if (may_command(row.to) && !any(row.with, kDeviceOurs | kVirtualRcOn)) {
      return false;
    }
  }
  return true;
}
static_assert(control_needs_proof());

/// Every row that requests control, or Virtual RC, tests the two-second sign.
constexpr bool requests_are_spaced() {
  for (const AuthorityRow& row : kAuthorityTable) {
    const bool bad_request = row.action == Action::kRequestControl && !all(row.with, kSpaced);
    const bool bad_switch = row.action == Action::kSwitchVirtualRcOn && !all(row.with, kSwitchSpaced);
    if (bad_request || bad_switch) {
      return false;
    }
  }
  return true;
}
static_assert(requests_are_spaced());

/// Only the operator leads out of silence, with one exception: after a port came back, start-up begins anew. It ends at
/// kReady, which again waits for the operator.
constexpr bool silence_ends_by_asking() {
  for (const AuthorityRow& row : kAuthorityTable) {
    const bool leaves = (row.from.has(Stage::kSilent) || row.from.has(Stage::kSilentCold)) &&
                        row.to != Stage::kSilent && row.to != Stage::kSilentCold;
    const bool starts_anew = all(row.with, kPortBack) && row.to == Stage::kListening;
    if (leaves && !all(row.with, kAsked) && !starts_anew) {
      return false;
    }
  }
  return true;
}
static_assert(silence_ends_by_asking());

}  // namespace checks
}  // namespace m100::safety
