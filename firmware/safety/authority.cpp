// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/safety/authority.h"

#include <array>
#include <cstddef>

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

/// Updates the counters and ages that an action changes.
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

/// Whether a row ends the operator's request for control: it is served, refused or withdrawn, control was lost, or the
/// port was opened anew.
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

/// Least time to the next release: five are 100 ms apart, the sixth a second after the first, the rest 200 ms apart.
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

constexpr std::array<std::string_view, kStageCount> kStageNames{
    "listening",          "asking_version", "activating", "setting_rates", "pausing",
    "awaiting_telemetry", "ready",          "obtaining",  "spacing",       "confirming",
    "enabling",           "in_control",     "releasing",  "silent",        "silent_cold"};

struct ReasonText {
  AuthorityReason reason;
  std::string_view name;
  std::string_view remedy;
};

constexpr std::array kReasons{
    ReasonText{AuthorityReason::kNone, "none", ""},
    ReasonText{AuthorityReason::kStarting, "starting", "wait"},
    ReasonText{
        AuthorityReason::kNothingReceived, "nothing_heard",
        "no frame from the autopilot: check cable, power, port and baud rate, and tick \"enable API control\" in "
        "DJI's assistant"},
    ReasonText{AuthorityReason::kNoAnswer, "no_answer",
               "frames arrive but the autopilot does not answer: check the line towards it (TX), then ask again"},
    ReasonText{AuthorityReason::kAnswer, "answer", "see the remedy of the autopilot's answer"},
    ReasonText{AuthorityReason::kNotActivated, "not_activated",
               "the autopilot says that this program is not activated: ask again to activate it"},
    ReasonText{
        AuthorityReason::kNoRcItem, "no_rc_item",
        "telemetry lacks the RC or the control item: switch the remote controller on, and set both items in DJI's "
        "assistant to 50 Hz or more"},
    ReasonText{AuthorityReason::kNotModeF, "not_mode_f",
               "move the mode switch of the remote controller to F, then ask again"},
    ReasonText{AuthorityReason::kRcOff, "rc_off", "switch the remote controller on, then ask again"},
    ReasonText{AuthorityReason::kEndlessObtaining, "endless_obtaining",
               "someone else holds control: end missions and close the mobile app, wait ten seconds, then ask again"},
    ReasonText{AuthorityReason::kNotConfirmed, "not_confirmed",
               "the autopilot's answer and its telemetry disagree about who is in control; control is given back: ask "
               "again"},
    ReasonText{AuthorityReason::kVirtualRcRefused, "virtual_rc_refused",
               "Virtual RC cannot be switched on: move the mode switch out of F and back, then ask again"},
    ReasonText{AuthorityReason::kGranted, "granted", ""},
    ReasonText{AuthorityReason::kReleased, "released", ""},
    ReasonText{AuthorityReason::kRestarted, "restarted",
               "the autopilot restarted: check that it works, then ask again"},
    ReasonText{AuthorityReason::kControlLost, "control_lost",
               "the autopilot took control away (mode switch, mobile app, or no transmitter): ask again when the pilot "
               "agrees"},
    ReasonText{AuthorityReason::kLinkSilent, "link_silent", "telemetry stopped: check the cable, then ask again"},
    ReasonText{AuthorityReason::kLeftModeF, "left_mode_f",
               "the pilot moved the mode switch out of F: move it back to F, then ask again"},
    ReasonText{AuthorityReason::kTaken, "taken",
               "the remote controller or the mobile app is in control: ask again when the pilot agrees"},
    ReasonText{
        AuthorityReason::kVirtualRcEnded, "virtual_rc_ended",
        "the autopilot ended Virtual RC (no data for a second, or the pilot's sticks); control is given back: ask "
        "again"},
    ReasonText{
        AuthorityReason::kOwnStall, "own_stall",
        "this program stalled for more than half a second; control is given back: find the cause (m100 doctor), then "
        "ask again"},
    ReasonText{AuthorityReason::kUplinkSilent, "unheard",
               "the autopilot no longer answers: our bytes do not reach it (check the line towards it, TX); control is "
               "given back: ask again"},
    ReasonText{AuthorityReason::kPortBack, "port_back",
               "the port is back and start-up begins anew: control is taken only after you ask again"},
};

constexpr bool in_order() {
  for (std::size_t i = 0; i < kReasons.size(); ++i) {
    if (static_cast<std::size_t>(kReasons[i].reason) != i) {
      return false;
    }
  }
  return kReasons.back().reason == AuthorityReason::kPortBack && kStageNames.back() == "silent_cold";
}
static_assert(in_order());

}  // namespace

AuthorityStep step(const AuthorityState& state, AuthorityCondition conditions, core::Duration elapsed) {
  M100_ASSERT(elapsed >= core::Duration{0});  // a shrinking age would delay releases (R15)
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

std::string_view name(AuthorityStage stage) { return kStageNames[static_cast<std::size_t>(stage)]; }
std::string_view name(AuthorityReason reason) { return kReasons[static_cast<std::size_t>(reason)].name; }
std::string_view remedy(AuthorityReason reason) { return kReasons[static_cast<std::size_t>(reason)].remedy; }

}  // namespace m100::safety
