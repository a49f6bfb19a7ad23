// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/safety/authority.h"

#include "firmware/core/assert.h"
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

AuthoritySign signs_of(const AuthorityState& state) {
  return when(state.asked, AuthoritySign::kAsked) |
         when(state.since_request >= kRequestSpacing, AuthoritySign::kSpaced) |
         when(state.requests < kRequestsPerAction, AuthoritySign::kTriesLeft) |
         when(state.since_switch >= kRequestSpacing, AuthoritySign::kSwitchSpaced) |
         when(state.switches < kRequestsPerAction, AuthoritySign::kSwitchesLeft) |
         when(state.since_entry >= longest_stay(state.stage), AuthoritySign::kTimeOver) |
         when(state.owed, AuthoritySign::kOwed);
}

/// Counters and ages that an action moves.
void note(Action action, AuthorityState& state) {
  switch (action) {
    case Action::kRequestControl:
      ++state.requests;
      state.owed = true;
      state.since_request = core::Duration{0};
      break;
    case Action::kSwitchVirtualRcOn:
      ++state.switches;
      state.owed = true;
      state.since_switch = core::Duration{0};
      break;
    case Action::kReleaseControl:
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
constexpr bool ends_ask(const AuthorityRow& row) {
  const bool refused_at_ready = row.from.has(Stage::kReady) && row.to == Stage::kReady;
  return refused_at_ready || row.to == Stage::kObtaining || row.to == Stage::kReleasing || row.to == Stage::kSilent ||
         row.to == Stage::kSilentCold || all(row.with, AuthoritySign::kPortBack);
}

constexpr bool shows_ours(AuthoritySign signs) {
  return any(signs, AuthoritySign::kDeviceOurs | AuthoritySign::kVirtualRcOn);
}
constexpr bool hears_items(AuthoritySign signs) {
  return all(signs, AuthoritySign::kHeard | AuthoritySign::kItemsFresh);
}

/// Whether control or Virtual RC may still be ours. Only telemetry that is younger than all our requests settles it.
bool still_owed(const AuthorityState& state, AuthoritySign signs) {
  const bool settled = hears_items(signs) && !state.must_release && state.since_request >= kGrantTime &&
                       state.since_switch >= kGrantTime;
  return shows_ours(signs) || (state.owed && !settled);
}

/// The sixth waits until the first is a second old; from then on they are evenly spaced.
constexpr core::Duration release_spacing(std::uint8_t releases) {
  if (releases < kReleasesAtOnce) {
    return kReleaseSpacing;
  }
  return releases == kReleasesAtOnce ? kReleaseWindow - (kReleasesAtOnce - 1) * kReleaseSpacing
                                     : kReleaseWindow / kReleasesAtOnce;
}

bool must_give_back(const AuthorityState& state, AuthoritySign signs) {
  const bool wants_it = (kAcquiring | Stage::kInControl).has(state.stage);
  const bool blind = state.owed && !hears_items(signs);
  return !wants_it && state.since_release >= release_spacing(state.releases) &&
         (state.must_release || shows_ours(signs) || blind);
}

}  // namespace

AuthorityStep step(const AuthorityState& state, AuthoritySign signs, core::Duration elapsed) {
  M100_ASSERT(elapsed >= core::Duration{0});  // an age that shrank would let a request leave too early (R4)
  AuthorityStep result{.state = state, .action = Action::kNone, .moved = false};
  AuthorityState& after = result.state;
  after.since_entry = older(state.since_entry, elapsed);
  after.since_request = older(state.since_request, elapsed);
  after.since_switch = older(state.since_switch, elapsed);
  after.since_release = older(state.since_release, elapsed);
  after.releases = after.since_release >= kReleaseWindow ? std::uint8_t{0} : state.releases;
  after.owed = still_owed(after, signs);
  if (any(signs, AuthoritySign::kAsked) && !(kAcquiring | kHolding).has(state.stage)) {
    after.asked = true;
    after.requests = 0;
    after.switches = 0;
  }
  after.asked = after.asked && !any(signs, AuthoritySign::kReleaseAsked);
  if (const AuthorityRow* const row = match(after.stage, (signs & ~AuthoritySign::kAsked) | signs_of(after))) {
    result.moved = true;
    result.action = row->action;
    after.since_entry = row->to == after.stage ? after.since_entry : core::Duration{0};
    after.stage = row->to;
    after.reason = row->reason == Reason::kNone ? after.reason : row->reason;
    after.asked = after.asked && !ends_ask(*row);
    after.must_release = after.must_release || row->action == Action::kReleaseControl;
  }
  // A row orders a release; its time is decided here, so that no two releases are closer than their spacing.
  result.action = result.action == Action::kReleaseControl ? Action::kNone : result.action;
  if (result.action == Action::kNone && must_give_back(after, signs)) {
    result.action = Action::kReleaseControl;
  }
  note(result.action, after);
  return result;
}

}  // namespace m100::safety
