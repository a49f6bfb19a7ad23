// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string_view>

#include "firmware/core/time.h"
#include "firmware/safety/condition_set.h"

namespace m100::safety {

// Start-up and authority of an onboard computer at the autopilot (protocol, section 11; promise R4), as one table. The
// table maps a stage and conditions to the next stage and an action. The owner of the link carries the action out.

enum class AuthorityStage : std::uint8_t {
  kListening,          ///< waits for a frame, at most kListenTime; then the version query is sent
  kRequestingVersion,  ///< version query open
  kActivating,         ///< activation open
  kSettingRates,       ///< telemetry frequencies open
  kPausing,            ///< start-up failed for a reason that may pass; starts again after kPauseTime
  kAwaitingTelemetry,  ///< activated; waits for fresh RC and control items
  kReady,              ///< control can be requested; waits for the operator
  kObtaining,          ///< request for control open
  kSpacing,            ///< the request must be repeated, but not before kRequestSpacing is over
  kConfirming,         ///< granted; telemetry does not show it yet (or Virtual RC must wait for its spacing)
  kEnabling,           ///< Virtual RC switched on; telemetry does not show it yet
  kInControl,          ///< the only stage in which commands may leave
  kReleasing,          ///< control is being given back on purpose, until telemetry shows it as not ours
  kSilent,             ///< control was lost or refused: only releases leave until the operator requests control
  kSilentCold,         ///< as kSilent, but a request begins with start-up, which failed or is not valid any more
};
inline constexpr std::size_t kStageCount = 15;

/// Conditions that the authority table tests. Levels are set for as long as they are true, edges for one step.
enum class AuthorityCondition : std::uint32_t {
  kNone = 0,
  // The operator (edges). step() stores a request for control until it is served, refused, withdrawn or void.
  kControlRequested = 1U << 0U,
  kReleaseRequested = 1U << 1U,
  // The link (levels; the restart and the push are edges).
  kLinkAlive = 1U << 2U,        ///< a good frame within the last 500 ms
  kItemsFresh = 1U << 3U,       ///< RC and control items within the last 500 ms
  kRestarted = 1U << 4U,        ///< the autopilot's clock jumped
  kControlLostPush = 1U << 5U,  ///< the autopilot's message that control was lost
  // Telemetry (levels).
  kModeF = 1U << 6U,
  kRcOff = 1U << 7U,
  kDeviceOurs = 1U << 8U,
  kVirtualRcOn = 1U << 9U,
  // Configuration (level).
  kNeedsVirtualRc = 1U << 10U,
  // The answer to the open request (edges).
  kDone = 1U << 11U,
  kSendAgain = 1U << 12U,  ///< "in progress: send the request again"
  kRetry = 1U << 13U,      ///< refused, but the cause may pass: mobile app, internet, version
  kRefused = 1U << 14U,    ///< refused, and a repetition is useless
  kNotActivated = 1U << 15U,
  kNoAnswer = 1U << 16U,
  // Made by step() from ages and counters.
  kRequestSpaced = 1U << 17U,  ///< the last request for control is at least kRequestSpacing old
  kTriesLeft = 1U << 18U,      ///< fewer than kRequestsPerAction requests for control since the operator's request
  kSwitchSpaced = 1U << 19U,   ///< the last Virtual RC "on" is at least kRequestSpacing old
  kSwitchesLeft = 1U << 20U,
  kTimeOver = 1U << 21U,        ///< the stage has lasted as long as it may
  kReleasePending = 1U << 22U,  ///< control or Virtual RC may be ours
  // Ourselves (edge).
  kOwnStall = 1U << 23U,  ///< our own program did not run for more than 500 ms
  // The link (edge).
  kPortBack = 1U << 24U,  ///< the port was opened anew: another autopilot may answer now
};

template <>
inline constexpr bool kIsCondition<AuthorityCondition> = true;

/// What the owner of the link must do after a step; a transition also drops any open request.
enum class AuthorityAction : std::uint8_t {
  kNone,
  kRequestVersion,
  kActivate,
  kSetRates,
  kRequestControl,
  kSwitchVirtualRcOn,
  kReleaseControl,  ///< Virtual RC off first, where it is used or on
};

/// Why the last transition was made, for the operator.
enum class AuthorityReason : std::uint8_t {
  kNone,
  kStarting,
  kNothingReceived,
  kNoAnswer,
  kAnswer,  ///< the autopilot's answer: its own name and remedy say more
  kNotActivated,
  kNoRcItem,
  kNotModeF,
  kRcOff,
  kEndlessObtaining,
  kNotConfirmed,
  kVirtualRcRefused,
  kGranted,
  kReleased,
  kRestarted,
  kControlLost,
  kLinkSilent,
  kLeftModeF,
  kTaken,
  kVirtualRcEnded,
  kOwnStall,
  kUplinkSilent,
  kPortBack,
};

std::string_view name(AuthorityStage stage);
std::string_view name(AuthorityReason reason);
/// What the operator should do about it.
std::string_view remedy(AuthorityReason reason);

inline constexpr core::Duration kRequestSpacing = std::chrono::seconds(2);  ///< R4; "on" of Virtual RC too
inline constexpr std::uint8_t kRequestsPerAction = 3;                       ///< R4: of control, and "on" of Virtual RC
inline constexpr core::Duration kListenTime = std::chrono::seconds(1);
inline constexpr core::Duration kPauseTime = std::chrono::seconds(5);
inline constexpr core::Duration kItemsTime = std::chrono::seconds(2);  ///< for RC and control items to appear
inline constexpr core::Duration kConfirmTime = std::chrono::seconds(1);
/// A release is sent at most five times in any second (R4). The first five are kReleaseSpacing apart. The sixth follows
/// kReleaseWindow after the first, and later ones are evenly spaced.
inline constexpr core::Duration kReleaseSpacing = std::chrono::milliseconds(100);
inline constexpr std::uint8_t kReleasesAtOnce = 5;
inline constexpr core::Duration kReleaseWindow = std::chrono::seconds(1);
/// A request is assumed to be granted within half of this time. The other half is the age at which items stop being
/// fresh: those fresh after this time are younger than the grant.
inline constexpr core::Duration kGrantTime = std::chrono::seconds(1);
/// Ages saturate here; longer than every time above.
inline constexpr core::Duration kAgeLimit = std::chrono::seconds(6);

/// Everything the table remembers. It stores ages instead of times, so that the state does not depend on the absolute
/// time and an exhaustive search of the states ends.
struct AuthorityState {
  AuthorityStage stage = AuthorityStage::kListening;
  AuthorityReason reason = AuthorityReason::kStarting;
  bool control_requested = false;
  std::uint8_t requests = 0;     ///< for control, since the operator's request
  std::uint8_t switches = 0;     ///< Virtual RC "on", since the operator's request
  bool release_pending = false;  ///< control or Virtual RC may be ours, until telemetry shows otherwise
  bool must_release = false;     ///< a release is due whatever telemetry shows
  core::Duration since_entry{0};
  core::Duration since_request = kAgeLimit;
  core::Duration since_switch = kAgeLimit;
  core::Duration since_release = kAgeLimit;
  std::uint8_t releases = 0;  ///< since a whole second without any; saturates at kReleasesAtOnce + 1
  friend constexpr bool operator==(const AuthorityState&, const AuthorityState&) = default;
};

struct AuthorityStep {
  AuthorityState state;
  AuthorityAction action = AuthorityAction::kNone;
  bool moved = false;  ///< a row matched: any open request is void
};

constexpr bool may_command(AuthorityStage stage) { return stage == AuthorityStage::kInControl; }

/// One step: applies at most one row of the table, then decides whether a release is sent (promise R15). Outside the
/// stages that acquire or have control, a release is sent after a row that orders one, while telemetry shows control or
/// Virtual RC as ours, and while it may be ours but telemetry is silent. The caller keeps the state.
/// @param elapsed since the step before, not negative.
AuthorityStep step(const AuthorityState& state, AuthorityCondition conditions, core::Duration elapsed);

}  // namespace m100::safety
