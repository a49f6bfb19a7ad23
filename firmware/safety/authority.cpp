// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/safety/authority.h"

#include "firmware/safety/authority_table.h"

namespace m100::safety {
namespace {

constexpr core::Duration older(core::Duration age, core::Duration elapsed) {
  return age + elapsed < kAgeLimit ? age + elapsed : kAgeLimit;
}

constexpr core::Duration longest_stay(Stage stage) {
  switch (stage) {
    case Stage::kListening:
      return kListenTime;
    case Stage::kAwaitingTelemetry:
      return kItemsTime;
    case Stage::kPausing:
      return kPauseTime;
    case Stage::kConfirming:
    case Stage::kEnabling:
      return kConfirmTime;
    default:
      return kAgeLimit + core::Duration{1};  // for ever
  }
}

Fact facts_of(const AuthorityState& state) {
  const std::uint8_t tries = state.stage == Stage::kReleasing ? state.releases : state.requests;
  return when(state.asked, Fact::kAsked) | when(state.since_request >= kRequestSpacing, Fact::kSpaced) |
         when(tries < kRequestsPerAction, Fact::kTriesLeft) |
         when(state.since_switch >= kRequestSpacing, Fact::kSwitchSpaced) |
         when(state.switches < kRequestsPerAction, Fact::kSwitchesLeft) |
         when(state.since_entry >= longest_stay(state.stage), Fact::kTimeOver);
}

/// Counters and ages that an action moves.
void note(Action action, AuthorityState& state) {
  switch (action) {
    case Action::kRequestControl:
      ++state.requests;
      state.since_request = core::Duration{0};
      break;
    case Action::kSwitchVirtualRcOn:
      ++state.switches;
      state.since_switch = core::Duration{0};
      break;
    case Action::kReleaseControl:
      ++state.releases;
      break;
    default:
      break;
  }
}

/// An ask is over when it is served, when it is refused, and when control is lost on the way.
constexpr bool ends_ask(const AuthorityRow& row) {
  const bool refused_at_ready = row.from.has(Stage::kReady) && row.to == Stage::kReady;
  return refused_at_ready || row.to == Stage::kObtaining || row.to == Stage::kReleasing || row.to == Stage::kSilent ||
         row.to == Stage::kSilentCold;
}

}  // namespace

AuthorityStep step(const AuthorityState& state, Fact facts, core::Duration elapsed) {
  AuthorityStep result{.state = state, .action = Action::kNone, .moved = false};
  AuthorityState& after = result.state;
  after.since_entry = older(state.since_entry, elapsed);
  after.since_request = older(state.since_request, elapsed);
  after.since_switch = older(state.since_switch, elapsed);
  if (any(facts, Fact::kAsked) && !(kAcquiring | kHolding).has(state.stage)) {
    after.asked = true;
    after.requests = 0;
    after.switches = 0;
  }
  const AuthorityRow* const row = match(after.stage, (facts & ~Fact::kAsked) | facts_of(after));
  if (row == nullptr) {
    return result;
  }
  result.moved = true;
  result.action = row->action;
  after.since_entry = row->to == after.stage ? after.since_entry : core::Duration{0};
  after.releases = row->to == Stage::kReleasing && after.stage == Stage::kReleasing ? after.releases : std::uint8_t{0};
  after.stage = row->to;
  after.reason = row->reason == Reason::kNone ? after.reason : row->reason;
  after.asked = after.asked && !ends_ask(*row);
  note(row->action, after);
  return result;
}

}  // namespace m100::safety
