// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string_view>

#include "firmware/core/time.h"
#include "firmware/safety/signs.h"

namespace m100::safety {

// Start-up and authority of an onboard computer at the autopilot (protocol, section 11; promise R4), as one table.
// Nothing here touches a wire: signs come in, a stage and an action come out, and whoever owns the link obeys.

enum class Stage : std::uint8_t {
  kListening,          ///< no frame yet; after kListenTime asks all the same
  kAskingVersion,      ///< version query open
  kActivating,         ///< activation open
  kSettingRates,       ///< telemetry frequencies open
  kPausing,            ///< start-up failed in a way that may heal; starts again after kPauseTime
  kAwaitingTelemetry,  ///< activated; RC and control items not seen yet
  kReady,              ///< could ask; waits for the operator
  kObtaining,          ///< request for control open
  kSpacing,            ///< asked before, must ask again, but not sooner than kRequestSpacing
  kConfirming,         ///< granted; telemetry does not show it yet (or Virtual RC must wait for its spacing)
  kEnabling,           ///< Virtual RC switched on; telemetry does not show it yet
  kInControl,          ///< the only stage in which commands may leave
  kReleasing,          ///< given back on purpose, until telemetry shows that it is
  kSilent,             ///< control was lost or refused: nothing but giving back leaves until the operator asks
  kSilentCold,         ///< the same, and the autopilot may have restarted: start-up is due after the operator asks
};
inline constexpr std::size_t kStageCount = 15;

/// What the authority table looks at. Levels hold for as long as they are true, edges for one step.
enum class AuthoritySign : std::uint32_t {
  kNone = 0,
  // The operator (edges; kAsked is kept until it is served or refused).
  kAsked = 1U << 0U,
  kReleaseAsked = 1U << 1U,
  // The link (levels, but for the restart).
  kHeard = 1U << 2U,       ///< a good frame within the last 500 ms
  kItemsFresh = 1U << 3U,  ///< RC and control items within the last 500 ms
  kRestarted = 1U << 4U,   ///< the autopilot's clock jumped
  kLostPush = 1U << 5U,    ///< control-lost push
  // Telemetry (levels).
  kModeF = 1U << 6U,
  kRcOff = 1U << 7U,
  kDeviceOurs = 1U << 8U,
  kVirtualRcOn = 1U << 9U,
  // Configuration (level).
  kNeedsVirtualRc = 1U << 10U,
  // The answer to what is open (edges).
  kDone = 1U << 11U,
  kAgain = 1U << 12U,    ///< "in progress: send the request again"
  kRetry = 1U << 13U,    ///< may heal: mobile app, internet, version
  kRefused = 1U << 14U,  ///< will not heal by asking
  kNotActivated = 1U << 15U,
  kNoAnswer = 1U << 16U,
  // Made by step() from ages and counters.
  kSpaced = 1U << 17U,        ///< the last request for control is at least kRequestSpacing old
  kTriesLeft = 1U << 18U,     ///< of the request that the stage is about
  kSwitchSpaced = 1U << 19U,  ///< the last Virtual RC "on" is at least kRequestSpacing old
  kSwitchesLeft = 1U << 20U,
  kTimeOver = 1U << 21U,  ///< the stage has lasted as long as it may
  kOwed = 1U << 22U,      ///< control or Virtual RC may be ours, as far as anybody can tell
  // Ourselves (edge).
  kOwnStall = 1U << 23U,  ///< our own program stood still for longer than it may
  // The link (edge).
  kPortBack = 1U << 24U,  ///< the port was opened anew: whoever answers now may be another
};

template <>
inline constexpr bool kIsSign<AuthoritySign> = true;

/// What the owner of the link must do on a transition, besides giving up whatever request is open.
enum class Action : std::uint8_t {
  kNone,
  kAskVersion,
  kActivate,
  kSetRates,
  kRequestControl,
  kSwitchVirtualRcOn,
  kReleaseControl,  ///< Virtual RC off first, where it is used or on
};

/// Why the last transition was made, for people.
enum class Reason : std::uint8_t {
  kNone,
  kStarting,
  kNothingHeard,
  kNoAnswer,
  kAnswer,  ///< the autopilot said so: the answer's own name and remedy tell
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
  kUnheard,
  kPortBack,
};

std::string_view name(Stage stage);
std::string_view name(Reason reason);
/// What whoever stands beside the aircraft should do about it.
std::string_view remedy(Reason reason);

inline constexpr core::Duration kRequestSpacing = std::chrono::seconds(2);  ///< R4; "on" of Virtual RC too
inline constexpr std::uint8_t kRequestsPerAction = 3;                       ///< R4, of each kind
inline constexpr core::Duration kListenTime = std::chrono::seconds(1);
inline constexpr core::Duration kPauseTime = std::chrono::seconds(5);
inline constexpr core::Duration kItemsTime = std::chrono::seconds(2);  ///< for RC and control items to appear
inline constexpr core::Duration kConfirmTime = std::chrono::seconds(1);
/// Giving back is said at most five times in any second (R4). The five of the first second leave at its beginning: an
/// autopilot wants to hear it twice, and of a bad line the second must have come within the second of R15. Then a pause
/// up to the full second, and from then on evenly.
inline constexpr core::Duration kReleaseSpacing = std::chrono::milliseconds(100);
inline constexpr std::uint8_t kReleasesAtOnce = 5;
inline constexpr core::Duration kReleaseWindow = std::chrono::seconds(1);
/// What is asked for may be granted so much later. Twice the age at which items stop being fresh, so that fresh items
/// of a time when this has passed are younger than the grant.
inline constexpr core::Duration kGrantTime = std::chrono::seconds(1);
/// Ages saturate here; longer than every time above.
inline constexpr core::Duration kAgeLimit = std::chrono::seconds(6);

/// Everything the table remembers. Ages instead of times: the state at one moment is the state at every moment, and an
/// exhaustive walk ends.
struct AuthorityState {
  Stage stage = Stage::kListening;
  Reason reason = Reason::kStarting;
  bool asked = false;
  std::uint8_t requests = 0;  ///< for control, since the operator asked
  std::uint8_t switches = 0;  ///< Virtual RC "on", since the operator asked
  bool owed = false;          ///< control or Virtual RC may be ours: not until telemetry says otherwise is it settled
  bool must_release = false;  ///< a release is due whatever telemetry shows
  core::Duration since_entry{0};
  core::Duration since_request = kAgeLimit;
  core::Duration since_switch = kAgeLimit;
  core::Duration since_release = kAgeLimit;
  std::uint8_t releases = 0;  ///< since a whole second without any; kReleasesAtOnce + 1: or more
  friend constexpr bool operator==(const AuthorityState&, const AuthorityState&) = default;
};

struct AuthorityStep {
  AuthorityState state;
  Action action = Action::kNone;
  bool moved = false;  ///< a row matched: whatever request was open is void
};

/// True in the one stage in which commands may leave.
constexpr bool may_command(Stage stage) { return stage == Stage::kInControl; }

/// One step, at most one row of the table, then what stands beside it (promise R15): in a stage that does not want
/// control, whatever telemetry shows as ours, and whatever may be ours while telemetry is silent, is given back, at
/// most five times a second, until telemetry shows that the transmitter has it. Pure: the caller keeps the state.
/// @param elapsed since the step before, not negative.
AuthorityStep step(const AuthorityState& state, AuthoritySign signs, core::Duration elapsed);

}  // namespace m100::safety
