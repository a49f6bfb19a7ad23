// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/safety/authority.h"

#include "firmware/core/assert.h"
#include "firmware/safety/authority_table.h"

namespace m100::safety {
namespace {

constexpr core::Duration older(core::Duration age, core::Duration elapsed) {
  return age + elapsed < kAgeLimit ? age + elapsed : kAgeLimit;
}

constexpr core::Duration longest_stay(AuthorityStage stage) {
  switch (stage) {
    case AuthorityStage::kListening:
      return kListenTime;
    case AuthorityStage::kAwaitingTelemetry:
      return kItemsTime;
    case AuthorityStage::kPausing:
      return kPauseTime;
    case AuthorityStage::kConfirming:
    case AuthorityStage::kEnabling:
      return kConfirmTime;
    default:
      return kAgeLimit + core::Duration{1};  // for ever
  }
}

AuthorityCondition conditions_of(const AuthorityState& state) {
  return when(state.control_requested, AuthorityCondition::kControlRequested) |
         when(state.since_request >= kRequestSpacing, AuthorityCondition::kRequestSpaced) |
         when(state.requests < kRequestsPerAction, AuthorityCondition::kTriesLeft) |
         when(state.since_switch >= kRequestSpacing, AuthorityCondition::kSwitchSpaced) |
         when(state.switches < kRequestsPerAction, AuthorityCondition::kSwitchesLeft) |
         when(state.since_entry >= longest_stay(state.stage), AuthorityCondition::kTimeOver) |
         when(state.release_pending, AuthorityCondition::kReleasePending);
}

/// Counters and ages that an action moves.
void note(AuthorityAction action, AuthorityState& state) {
  switch (action) {
    case AuthorityAction::kRequestControl:
      ++state.requests;
      state.release_pending = true;
      state.since_request = core::Duration{0};
      break;
    case AuthorityAction::kSwitchVirtualRcOn:
      ++state.switches;
      state.release_pending = true;
      state.since_switch = core::Duration{0};
      break;
    case AuthorityAction::kReleaseControl:
      state.must_release = false;
      state.since_release = core::Duration{0};
      state.releases =
          state.releases > kReleasesAtOnce ? state.releases : static_cast<std::uint8_t>(state.releases + 1);
      break;
    default:
      break;
  }
}

/// An ask ends when it is served, when it is refused, when control is lost on the way, and when a port came back: it
/// was not meant for the autopilot that answers there now.
constexpr bool ends_ask(const AuthorityTransition& row) {
  const bool refused_at_ready = row.from.has(AuthorityStage::kReady) && row.to == AuthorityStage::kReady;
  return refused_at_ready || row.to == AuthorityStage::kObtaining || row.to == AuthorityStage::kReleasing ||
         row.to == AuthorityStage::kSilent || row.to == AuthorityStage::kSilentCold ||
         all(row.with, AuthorityCondition::kPortBack);
}

constexpr bool shows_ours(AuthorityCondition conditions) {
  return any(conditions, AuthorityCondition::kDeviceOurs | AuthorityCondition::kVirtualRcOn);
}
constexpr bool hears_items(AuthorityCondition conditions) {
  return all(conditions, AuthorityCondition::kLinkAlive | AuthorityCondition::kItemsFresh);
}

/// Whether control or Virtual RC may still be ours. Only telemetry that is younger than all our requests settles it.
bool is_release_pending(const AuthorityState& state, AuthorityCondition conditions) {
  const bool settled = hears_items(conditions) && !state.must_release && state.since_request >= kGrantTime &&
                       state.since_switch >= kGrantTime;
  return shows_ours(conditions) || (state.release_pending && !settled);
}

/// The sixth waits until the first is a second old; from then on they are evenly spaced.
constexpr core::Duration release_spacing(std::uint8_t releases) {
  if (releases < kReleasesAtOnce) {
    return kReleaseSpacing;
  }
  return releases == kReleasesAtOnce ? kReleaseWindow - (kReleasesAtOnce - 1) * kReleaseSpacing
                                     : kReleaseWindow / kReleasesAtOnce;
}

bool must_give_back(const AuthorityState& state, AuthorityCondition conditions) {
  const bool wants_it = (kAcquiring | AuthorityStage::kInControl).has(state.stage);
  const bool blind = state.release_pending && !hears_items(conditions);
  return !wants_it && state.since_release >= release_spacing(state.releases) &&
         (state.must_release || shows_ours(conditions) || blind);
}

}  // namespace

AuthorityStep step(const AuthorityState& state, AuthorityCondition conditions, core::Duration elapsed) {
  M100_ASSERT(elapsed >= core::Duration{0});  // an age that shrank would let a request leave too early (R4)
  AuthorityStep result{.state = state, .action = AuthorityAction::kNone, .moved = false};
  AuthorityState& after = result.state;
  after.since_entry = older(state.since_entry, elapsed);
  after.since_request = older(state.since_request, elapsed);
  after.since_switch = older(state.since_switch, elapsed);
  after.since_release = older(state.since_release, elapsed);
  after.releases = after.since_release >= kReleaseWindow ? std::uint8_t{0} : state.releases;
  after.release_pending = is_release_pending(after, conditions);
  if (any(conditions, AuthorityCondition::kControlRequested) && !(kAcquiring | kHolding).has(state.stage)) {
    after.control_requested = true;
    after.requests = 0;
    after.switches = 0;
  }
  after.control_requested = after.control_requested && !any(conditions, AuthorityCondition::kReleaseRequested);
  if (const AuthorityTransition* const row =
          match(after.stage, (conditions & ~AuthorityCondition::kControlRequested) | conditions_of(after))) {
    result.moved = true;
    result.action = row->action;
    after.since_entry = row->to == after.stage ? after.since_entry : core::Duration{0};
    after.stage = row->to;
    after.reason = row->reason == AuthorityReason::kNone ? after.reason : row->reason;
    after.control_requested = after.control_requested && !ends_ask(*row);
    after.must_release = after.must_release || row->action == AuthorityAction::kReleaseControl;
  }
  // A row orders a release; its time is decided here, so that no two releases are closer than their spacing.
  result.action = result.action == AuthorityAction::kReleaseControl ? AuthorityAction::kNone : result.action;
  if (result.action == AuthorityAction::kNone && must_give_back(after, conditions)) {
    result.action = AuthorityAction::kReleaseControl;
  }
  note(result.action, after);
  return result;
}

}  // namespace m100::safety
