// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware/safety/authority.h"
#include "firmware/safety/transition_table.h"

namespace m100::safety {

/// A set of stages, so that one row can stand for several.
struct StageSet {
  std::uint32_t bits = 0;
  constexpr StageSet() = default;
  constexpr StageSet(AuthorityStage stage)
      : bits(1U << static_cast<unsigned>(stage)) {}  // NOLINT: a stage is a set of one
  constexpr bool has(AuthorityStage stage) const { return (bits >> static_cast<unsigned>(stage) & 1U) != 0; }
  friend constexpr StageSet operator|(StageSet a, StageSet b) {
    a.bits |= b.bits;
    return a;
  }
};
constexpr StageSet operator|(AuthorityStage a, AuthorityStage b) { return StageSet(a) | StageSet(b); }

struct AuthorityTransition {
  StageSet from;
  AuthorityCondition with;     ///< all of these hold
  AuthorityCondition without;  ///< none of these does
  AuthorityStage to;
  AuthorityAction action;
  AuthorityReason reason;
};

inline constexpr StageSet kStartUp =
    AuthorityStage::kRequestingVersion | AuthorityStage::kActivating | AuthorityStage::kSettingRates;
inline constexpr StageSet kIdle = AuthorityStage::kAwaitingTelemetry | AuthorityStage::kReady | AuthorityStage::kSilent;
inline constexpr StageSet kAcquiring =
    AuthorityStage::kObtaining | AuthorityStage::kSpacing | AuthorityStage::kConfirming | AuthorityStage::kEnabling;
inline constexpr StageSet kHolding = AuthorityStage::kInControl | AuthorityStage::kReleasing;
inline constexpr StageSet kEveryStage = kStartUp | kIdle | kAcquiring | kHolding | AuthorityStage::kListening |
                                        AuthorityStage::kPausing | AuthorityStage::kSilentCold;

/// Short names for the rows of the table.
namespace authority_rows {

using enum AuthorityCondition;
using Row = AuthorityTransition;
using S = AuthorityStage;
using A = AuthorityAction;
using R = AuthorityReason;

/// Read from top to bottom, the first row that matches wins. If no row matches, the stage stays.
inline constexpr std::array kAuthorityTable{
    // Loss of authority is tested before anything else. Control that is still ours then is given back by step().
    Row{kEveryStage, kPortBack, kNone, S::kListening, A::kNone, R::kPortBack},
    Row{kAcquiring | kHolding, kOwnStall, kNone, S::kSilent, A::kReleaseControl, R::kOwnStall},
    Row{kAcquiring | kHolding | kIdle, kRestarted, kNone, S::kSilentCold, A::kNone, R::kRestarted},
    Row{kStartUp | S::kPausing, kRestarted, kNone, S::kListening, A::kNone, R::kRestarted},
    Row{kAcquiring | kHolding, kControlLostPush, kNone, S::kSilent, A::kNone, R::kControlLost},
    Row{kAcquiring | kHolding | kIdle, kNone, kLinkAlive, S::kSilentCold, A::kNone, R::kLinkSilent},
    Row{kAcquiring | kHolding, kNone, kItemsFresh, S::kSilentCold, A::kNone, R::kLinkSilent},
    Row{kAcquiring | kHolding, kNone, kModeF, S::kSilent, A::kNone, R::kLeftModeF},
    Row{S::kEnabling | S::kInControl, kNone, kDeviceOurs, S::kSilent, A::kNone, R::kTaken},
    Row{S::kInControl, kNeedsVirtualRc, kVirtualRcOn, S::kSilent, A::kNone, R::kVirtualRcEnded},
    Row{S::kInControl, kNoAnswer, kNone, S::kSilent, A::kReleaseControl, R::kUplinkSilent},

    // The operator gives control back.
    Row{kAcquiring | S::kInControl, kReleaseRequested, kNone, S::kReleasing, A::kReleaseControl, R::kNone},
    Row{S::kReleasing, kNone, kReleasePending, S::kReady, A::kNone, R::kReleased},

    // Start-up, by itself, until the first loss.
    Row{S::kListening, kLinkAlive, kNone, S::kRequestingVersion, A::kRequestVersion, R::kStarting},
    Row{S::kListening, kTimeOver, kNone, S::kRequestingVersion, A::kRequestVersion, R::kNothingReceived},
    Row{S::kRequestingVersion, kDone, kNone, S::kActivating, A::kActivate, R::kStarting},
    Row{S::kRequestingVersion, kNoAnswer, kLinkAlive, S::kPausing, A::kNone, R::kNothingReceived},
    Row{S::kActivating, kDone, kNone, S::kSettingRates, A::kSetRates, R::kStarting},
    Row{S::kSettingRates, kDone, kNone, S::kAwaitingTelemetry, A::kNone, R::kStarting},
    Row{kStartUp, kRetry, kNone, S::kPausing, A::kNone, R::kAnswer},
    Row{kStartUp, kNoAnswer, kNone, S::kPausing, A::kNone, R::kNoAnswer},
    Row{kStartUp, kSendAgain, kNone, S::kPausing, A::kNone, R::kAnswer},
    Row{kStartUp, kRefused, kNone, S::kSilentCold, A::kNone, R::kAnswer},
    Row{kStartUp, kNotActivated, kNone, S::kPausing, A::kNone, R::kNotActivated},
    Row{S::kPausing, kTimeOver, kNone, S::kListening, A::kNone, R::kStarting},
    Row{S::kAwaitingTelemetry, kItemsFresh, kNone, S::kReady, A::kNone, R::kNone},
    Row{S::kAwaitingTelemetry, kTimeOver, kNone, S::kAwaitingTelemetry, A::kNone, R::kNoRcItem},

    // The operator requests control.
    Row{S::kSilentCold, kControlRequested, kNone, S::kListening, A::kNone, R::kStarting},
    Row{S::kSilent, kControlRequested, kNone, S::kAwaitingTelemetry, A::kNone, R::kStarting},
    Row{S::kReady, kNone, kItemsFresh, S::kAwaitingTelemetry, A::kNone, R::kNoRcItem},
    Row{S::kReady, kControlRequested | kRcOff, kNone, S::kReady, A::kNone, R::kRcOff},
    Row{S::kReady, kControlRequested, kModeF, S::kReady, A::kNone, R::kNotModeF},
    Row{S::kReady, kControlRequested | kRequestSpaced, kReleasePending, S::kObtaining, A::kRequestControl,
        R::kStarting},

    // Every request has to be sent twice: the first is answered "again" (protocol, 6.1). Telemetry may show that
    // control is ours before the answer does, or instead of it.
    Row{S::kObtaining | S::kSpacing, kDeviceOurs, kNone, S::kConfirming, A::kNone, R::kGranted},
    Row{S::kObtaining, kDone, kNone, S::kConfirming, A::kNone, R::kGranted},
    Row{S::kObtaining, kSendAgain | kTriesLeft, kNone, S::kSpacing, A::kNone, R::kStarting},
    Row{S::kObtaining, kNoAnswer | kTriesLeft, kNone, S::kSpacing, A::kNone, R::kNoAnswer},
    Row{S::kObtaining, kSendAgain, kNone, S::kSilent, A::kNone, R::kEndlessObtaining},
    Row{S::kObtaining, kNoAnswer, kNone, S::kSilent, A::kNone, R::kNoAnswer},
    Row{S::kObtaining, kRetry, kNone, S::kSilent, A::kNone, R::kAnswer},
    Row{S::kObtaining, kRefused, kNone, S::kSilent, A::kNone, R::kAnswer},
    Row{S::kObtaining, kNotActivated, kNone, S::kSilentCold, A::kNone, R::kNotActivated},
    Row{S::kSpacing, kRequestSpaced, kNone, S::kObtaining, A::kRequestControl, R::kStarting},
    Row{S::kConfirming, kDeviceOurs, kNeedsVirtualRc, S::kInControl, A::kNone, R::kGranted},
    Row{S::kConfirming, kDeviceOurs | kSwitchSpaced, kNone, S::kEnabling, A::kSwitchVirtualRcOn, R::kGranted},
    Row{S::kConfirming, kTimeOver, kDeviceOurs, S::kSilent, A::kReleaseControl, R::kNotConfirmed},
    Row{S::kEnabling, kVirtualRcOn, kNone, S::kInControl, A::kNone, R::kGranted},
    Row{S::kEnabling, kTimeOver | kSwitchesLeft, kNone, S::kConfirming, A::kNone, R::kGranted},
    Row{S::kEnabling, kTimeOver, kNone, S::kSilent, A::kReleaseControl, R::kVirtualRcRefused},
};

}  // namespace authority_rows
using authority_rows::kAuthorityTable;

/// The most rows that one stage has.
inline constexpr std::size_t kMaxRowsOfStage = [] {
  std::array<std::size_t, kStageCount> rows{};
  std::size_t most = 0;
  for (std::size_t stage = 0; stage < kStageCount; ++stage) {
    for (const AuthorityTransition& row : kAuthorityTable) {
      rows[stage] += row.from.has(static_cast<AuthorityStage>(stage)) ? 1U : 0U;
    }
    most = rows[stage] > most ? rows[stage] : most;
  }
  return most;
}();

/// The rows of each stage by number, in the order of the table, followed by the table's size. A pass over the whole
/// table in every tick would cost more than everything else here.
inline constexpr auto kRowsOfStage = [] {
  std::array<std::array<std::uint8_t, kMaxRowsOfStage + 1>, kStageCount> rows{};
  for (std::size_t stage = 0; stage < kStageCount; ++stage) {
    std::size_t count = 0;
    for (std::size_t number = 0; number < kAuthorityTable.size(); ++number) {
      if (kAuthorityTable[number].from.has(static_cast<AuthorityStage>(stage))) {
        rows[stage][count++] = static_cast<std::uint8_t>(number);
      }
    }
    rows[stage][count] = static_cast<std::uint8_t>(kAuthorityTable.size());
  }
  return rows;
}();
static_assert(kAuthorityTable.size() < 256);

/// Number of the first row that matches; the table's size if none does.
constexpr std::size_t match_number(AuthorityStage stage, AuthorityCondition conditions) {
  for (const std::uint8_t number : kRowsOfStage[static_cast<std::size_t>(stage)]) {
    if (number == kAuthorityTable.size()) {
      break;
    }
    const AuthorityTransition& row = kAuthorityTable[number];
    if (all(conditions, row.with) && !any(conditions, row.without) && is_on<AuthorityTransition>(number)) {
      return number;
    }
  }
  return kAuthorityTable.size();
}

/// The row that matches, or null.
constexpr const AuthorityTransition* match(AuthorityStage stage, AuthorityCondition conditions) {
  const std::size_t number = match_number(stage, conditions);
  return number < kAuthorityTable.size() ? &kAuthorityTable[number] : nullptr;
}

/// The stage after one look-up in the table. (By number: GCC's sanitizers do not let a constant expression compare
/// addresses.)
constexpr AuthorityStage next(AuthorityStage stage, AuthorityCondition conditions) {
  const std::size_t number = match_number(stage, conditions);
  return number < kAuthorityTable.size() ? kAuthorityTable[number].to : stage;
}

namespace checks {

using S = AuthorityStage;
using enum AuthorityCondition;
/// All is well in flight, over Virtual RC.
inline constexpr AuthorityCondition kFlying =
    kLinkAlive | kItemsFresh | kModeF | kDeviceOurs | kVirtualRcOn | kNeedsVirtualRc;

constexpr AuthorityCondition except(AuthorityCondition conditions, AuthorityCondition gone) {
  return conditions & ~gone;
}

static_assert(next(S::kInControl, kFlying) == S::kInControl);
static_assert(next(S::kInControl, except(kFlying, kModeF)) == S::kSilent);
static_assert(next(S::kInControl, except(kFlying, kDeviceOurs)) == S::kSilent);
static_assert(next(S::kInControl, except(kFlying, kVirtualRcOn)) == S::kSilent);
static_assert(next(S::kInControl, except(kFlying, kItemsFresh)) == S::kSilentCold);
static_assert(next(S::kInControl, except(kFlying, kLinkAlive)) == S::kSilentCold);
static_assert(next(S::kInControl, kFlying | kControlLostPush | kReleaseRequested) == S::kSilent, "loss before wishes");
static_assert(next(S::kInControl, kFlying | kRestarted | kControlLostPush) == S::kSilentCold);
static_assert(next(S::kInControl, except(kFlying, kVirtualRcOn | kNeedsVirtualRc)) == S::kInControl,
              "the movement channel does not need Virtual RC");
static_assert(next(S::kSilent, kFlying | kRequestSpaced | kTriesLeft | kDone) == S::kSilent, "never by itself");
static_assert(next(S::kSilentCold, kFlying | kRequestSpaced | kTriesLeft | kDone) == S::kSilentCold);
static_assert(next(S::kReady, kFlying | kRequestSpaced | kTriesLeft) == S::kReady, "not unasked");
static_assert(next(S::kReady, kFlying | kControlRequested) == S::kReady, "not before two seconds have passed");
static_assert(next(S::kReady, kFlying | kControlRequested | kRequestSpaced) == S::kObtaining);
static_assert(next(S::kReady, kFlying | kControlRequested | kRequestSpaced | kReleasePending) == S::kReady,
              "first it is given back");
static_assert(next(S::kReleasing, kFlying | kReleasePending | kDone) == S::kReleasing,
              "telemetry decides, not an answer");
static_assert(next(S::kInControl, kFlying | kOwnStall) == S::kSilent);
static_assert(next(S::kInControl, kFlying | kNoAnswer) == S::kSilent, "nobody hears us");
static_assert(next(S::kInControl, kFlying | kPortBack) == S::kListening);
static_assert(next(S::kSilentCold, kFlying | kPortBack) == S::kListening);
static_assert(kAuthorityTable[match_number(S::kReady, except(kFlying, kModeF) | kControlRequested | kRequestSpaced)]
                  .reason == AuthorityReason::kNotModeF);
static_assert(next(S::kObtaining, except(kFlying, kDeviceOurs) | kSendAgain) == S::kSilent,
              "someone else holds control");
static_assert(next(S::kObtaining, except(kFlying, kDeviceOurs) | kSendAgain | kTriesLeft) == S::kSpacing);
static_assert(next(S::kObtaining, kFlying | kNoAnswer) == S::kConfirming, "telemetry says that it is granted");

/// Every row that leads to a stage in which commands may leave requires control or Virtual RC as ours in telemetry.
constexpr bool control_needs_proof() {
  for (const AuthorityTransition& row : kAuthorityTable) {
    if (may_command(row.to) && !any(row.with, kDeviceOurs | kVirtualRcOn)) {
      return false;
    }
  }
  return true;
}
static_assert(control_needs_proof());

/// Every row that requests control or switches Virtual RC on requires that the last such request is two seconds old.
constexpr bool requests_are_spaced() {
  for (const AuthorityTransition& row : kAuthorityTable) {
    const bool bad_request = row.action == AuthorityAction::kRequestControl && !all(row.with, kRequestSpaced);
    const bool bad_switch = row.action == AuthorityAction::kSwitchVirtualRcOn && !all(row.with, kSwitchSpaced);
    if (bad_request || bad_switch) {
      return false;
    }
  }
  return true;
}
static_assert(requests_are_spaced());

/// Every row that leaves kSilent and kSilentCold requires a request of the operator, except the row for a port that was
/// opened anew. That row starts the start-up, which ends at kReady and waits for the operator there.
constexpr bool silence_ends_by_asking() {
  for (const AuthorityTransition& row : kAuthorityTable) {
    const bool leaves =
        (row.from.has(S::kSilent) || row.from.has(S::kSilentCold)) && row.to != S::kSilent && row.to != S::kSilentCold;
    const bool starts_anew = all(row.with, kPortBack) && row.to == S::kListening;
    if (leaves && !all(row.with, kControlRequested) && !starts_anew) {
      return false;
    }
  }
  return true;
}
static_assert(silence_ends_by_asking());

}  // namespace checks
}  // namespace m100::safety
