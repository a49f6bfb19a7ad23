// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/unit/safety/situations.h"

namespace m100::safety::situations {
namespace {

using enum AuthorityCondition;
using S = AuthorityStage;
using X = AuthorityAction;
using R = AuthorityReason;
using A = AuthoritySituation;

// The stages are written out by hand, so that a stage that is missing in a set of the table is found.
constexpr StageSet kAsking = S::kObtaining | S::kSpacing | S::kConfirming | S::kEnabling;
constexpr StageSet kOurs = kAsking | S::kInControl | S::kReleasing;
constexpr StageSet kStarting = S::kRequestingVersion | S::kActivating | S::kSettingRates;
constexpr StageSet kWaiting = S::kAwaitingTelemetry | S::kReady | S::kSilent;
constexpr StageSet kAll = kOurs | kStarting | kWaiting | S::kListening | S::kPausing | S::kSilentCold;

}  // namespace

const std::array<AuthoritySituation, 76> kAuthoritySituations{
    // Losses.
    A{"ThePortWasOpenedAnew", kAll, kAir | kPortBack, S::kListening, X::kNone, R::kPortBack},
    A{"AnotherAutopilotBehindThePort", kAll, kAir | kPortBack | kRestarted, S::kListening, X::kNone, R::kPortBack},
    A{"WeStoodStill", kOurs, kAir | kOwnStall, S::kSilent, X::kReleaseControl, R::kOwnStall},
    A{"TheStallIsToldBeforeTheRestartThatItLooksLike", kOurs, kAir | kOwnStall | kRestarted, S::kSilent,
      X::kReleaseControl, R::kOwnStall},
    A{"TheAutopilotRestarts", kOurs | kWaiting, kAir | kRestarted, S::kSilentCold, X::kNone, R::kRestarted},
    A{"TheAutopilotRestartsDuringStartUp", kStarting | S::kPausing, kLinkUp | kRestarted, S::kListening, X::kNone,
      R::kRestarted},
    A{"ControlIsTakenByAPush", kOurs, kAir | kControlLostPush, S::kSilent, X::kNone, R::kControlLost},
    A{"ALossComesBeforeAWish", S::kInControl, kAir | kControlLostPush | kReleaseRequested, S::kSilent, X::kNone,
      R::kControlLost},
    A{"TheLineIsCut", kOurs | kWaiting, without(kAir, kLinkAlive | kItemsFresh), S::kSilentCold, X::kNone,
      R::kLinkSilent},
    A{"NothingIsHeard", kOurs | kWaiting, without(kAir, kLinkAlive), S::kSilentCold, X::kNone, R::kLinkSilent},
    A{"TheItemsThatTellGrowOld", kOurs, without(kAir, kItemsFresh), S::kSilentCold, X::kNone, R::kLinkSilent},
    A{"ThePilotTurnsTheModeSwitch", kOurs, without(kAir, kModeF), S::kSilent, X::kNone, R::kLeftModeF},
    A{"TheModeSwitchComesBeforeAGrant", kAsking, without(kAir, kModeF) | kDone, S::kSilent, X::kNone, R::kLeftModeF},
    A{"AnotherDeviceCommands", S::kEnabling | S::kInControl, without(kAir, kDeviceOurs), S::kSilent, X::kNone,
      R::kTaken},
    A{"VirtualRcEnds", S::kInControl, without(kAir, kVirtualRcOn), S::kSilent, X::kNone, R::kVirtualRcEnded},
    A{"MovementNeedsNoVirtualRc", S::kInControl, without(kAir, kVirtualRcOn | kNeedsVirtualRc), S::kInControl, X::kNone,
      R::kNone, true},
    A{"NobodyHearsUs", S::kInControl, kAir | kNoAnswer, S::kSilent, X::kReleaseControl, R::kUplinkSilent},
    A{"AllIsWell", S::kInControl, kAir, S::kInControl, X::kNone, R::kNone, true},

    // The operator gives control back.
    A{"TheOperatorGivesBack", kAsking | S::kInControl, kAir | kReleaseRequested, S::kReleasing, X::kReleaseControl},
    A{"NothingIsOursAnyMore", S::kReleasing, kGround, S::kReady, X::kNone, R::kReleased},
    A{"AnAnswerAloneFinishesNoRelease", S::kReleasing, kAir | kDone, S::kReleasing, X::kNone, R::kNone, true},
    A{"NoAnswerFinishesNoRelease", S::kReleasing, kAir | kNoAnswer, S::kReleasing, X::kNone, R::kNone, true},

    // Start-up.
    A{"SomebodySpeaks", S::kListening, kLinkUp, S::kRequestingVersion, X::kRequestVersion, R::kStarting},
    A{"NobodySpeaks", S::kListening, kTimeOver, S::kRequestingVersion, X::kRequestVersion, R::kNothingReceived},
    A{"ItIsListenedForAWhile", S::kListening, kNone, S::kListening, X::kNone, R::kNone, true},
    A{"TheVersionIsKnown", S::kRequestingVersion, kLinkUp | kDone, S::kActivating, X::kActivate, R::kStarting},
    A{"NobodyAnswersAndNobodySpeaks", S::kRequestingVersion, kNoAnswer, S::kPausing, X::kNone, R::kNothingReceived},
    A{"ItIsActivated", S::kActivating, kLinkUp | kDone, S::kSettingRates, X::kSetRates, R::kStarting},
    A{"TheRatesAreSet", S::kSettingRates, kLinkUp | kDone, S::kAwaitingTelemetry, X::kNone, R::kStarting},
    A{"AnAnswerThatMayHeal", kStarting, kLinkUp | kRetry, S::kPausing, X::kNone, R::kAnswer},
    A{"SpeaksAndAnswersNothing", kStarting, kLinkUp | kNoAnswer, S::kPausing, X::kNone, R::kNoAnswer},
    A{"AskedToComeAgain", kStarting, kLinkUp | kSendAgain, S::kPausing, X::kNone, R::kAnswer},
    A{"AnAnswerThatWillNotHeal", kStarting, kLinkUp | kRefused, S::kSilentCold, X::kNone, R::kAnswer},
    A{"NotActivated", kStarting, kLinkUp | kNotActivated, S::kPausing, X::kNone, R::kNotActivated},
    A{"AnAnswerIsWaitedFor", kStarting, kLinkUp, S::kListening, X::kNone, R::kNone, true},
    A{"ThePauseIsOver", S::kPausing, kLinkUp | kTimeOver, S::kListening, X::kNone, R::kStarting},
    A{"ThePauseLasts", S::kPausing, kLinkUp, S::kPausing, X::kNone, R::kNone, true},
    A{"TheItemsArrive", S::kAwaitingTelemetry, kLinkUp | kItemsFresh, S::kReady},
    A{"TheItemsDoNotArrive", S::kAwaitingTelemetry, kLinkUp | kTimeOver, S::kAwaitingTelemetry, X::kNone, R::kNoRcItem},
    A{"TheItemsAreWaitedFor", S::kAwaitingTelemetry, kLinkUp | kModeF, S::kAwaitingTelemetry, X::kNone, R::kNone, true},

    // The operator asks.
    A{"AskedAfterACut", S::kSilentCold, kGround | kControlRequested, S::kListening, X::kNone, R::kStarting},
    A{"AskedAfterALoss", S::kSilent, kGround | kControlRequested, S::kAwaitingTelemetry, X::kNone, R::kStarting},
    A{"NobodyAsksAfterALoss", S::kSilent | S::kSilentCold, kGround | kDone, S::kSilent, X::kNone, R::kNone, true},
    A{"TheItemsStayAwayOnTheGround", S::kReady, without(kGround, kItemsFresh), S::kAwaitingTelemetry, X::kNone,
      R::kNoRcItem},
    A{"TheItemsAreLookedAtBeforeTheAsk", S::kReady, without(kGround, kItemsFresh) | kControlRequested,
      S::kAwaitingTelemetry, X::kNone, R::kNoRcItem},
    A{"TheTransmitterIsOff", S::kReady, kGround | kControlRequested | kRcOff, S::kReady, X::kNone, R::kRcOff},
    A{"AnOffTransmitterComesBeforeItsSwitch", S::kReady, without(kGround, kModeF) | kControlRequested | kRcOff,
      S::kReady, X::kNone, R::kRcOff},
    A{"TheSwitchIsNotAtF", S::kReady, without(kGround, kModeF) | kControlRequested, S::kReady, X::kNone, R::kNotModeF},
    A{"AskedOnTheGround", S::kReady, kGround | kControlRequested, S::kObtaining, X::kRequestControl, R::kStarting},
    A{"AskedTooSoon", S::kReady, without(kGround, kRequestSpaced) | kControlRequested, S::kReady, X::kNone, R::kNone,
      true},
    A{"AskedWhileSomethingIsOurs", S::kReady, kGround | kControlRequested | kReleasePending, S::kReady, X::kNone,
      R::kNone, true},
    A{"NobodyAsks", S::kReady, kGround, S::kReady, X::kNone, R::kNone, true},

    // The request, twice.
    A{"TelemetrySaysItIsOurs", S::kObtaining | S::kSpacing, kGround | kDeviceOurs, S::kConfirming, X::kNone,
      R::kGranted},
    A{"TelemetryComesBeforeTheAnswer", S::kObtaining, kGround | kDeviceOurs | kRefused, S::kConfirming, X::kNone,
      R::kGranted},
    A{"Granted", S::kObtaining, kGround | kDone, S::kConfirming, X::kNone, R::kGranted},
    A{"TheFirstAnswerIsAgain", S::kObtaining, kGround | kSendAgain, S::kSpacing, X::kNone, R::kStarting},
    A{"TheFirstAnswerIsLost", S::kObtaining, kGround | kNoAnswer, S::kSpacing, X::kNone, R::kNoAnswer},
    A{"AgainWithoutEnd", S::kObtaining, without(kGround, kTriesLeft) | kSendAgain, S::kSilent, X::kNone,
      R::kEndlessObtaining},
    A{"NoAnswerAtAll", S::kObtaining, without(kGround, kTriesLeft) | kNoAnswer, S::kSilent, X::kNone, R::kNoAnswer},
    A{"RefusedForNow", S::kObtaining, kGround | kRetry, S::kSilent, X::kNone, R::kAnswer},
    A{"Refused", S::kObtaining, kGround | kRefused, S::kSilent, X::kNone, R::kAnswer},
    A{"RefusedBecauseNotActivated", S::kObtaining, kGround | kNotActivated, S::kSilentCold, X::kNone, R::kNotActivated},
    A{"TheAnswerIsWaitedFor", S::kObtaining, kGround, S::kObtaining, X::kNone, R::kNone, true},
    A{"TwoSecondsHavePassed", S::kSpacing, kGround, S::kObtaining, X::kRequestControl, R::kStarting},
    A{"TwoSecondsHaveNotPassed", S::kSpacing, without(kGround, kRequestSpaced), S::kSpacing, X::kNone, R::kNone, true},
    A{"ConfirmedForMovement", S::kConfirming, without(kGround, kNeedsVirtualRc) | kDeviceOurs, S::kInControl, X::kNone,
      R::kGranted},
    A{"ConfirmedForVirtualRc", S::kConfirming, kGround | kDeviceOurs, S::kEnabling, X::kSwitchVirtualRcOn, R::kGranted},
    A{"ConfirmedForVirtualRcTooSoon", S::kConfirming, without(kGround, kSwitchSpaced) | kDeviceOurs, S::kConfirming,
      X::kNone, R::kNone, true},
    A{"NotConfirmed", S::kConfirming, kGround | kTimeOver, S::kSilent, X::kReleaseControl, R::kNotConfirmed},
    A{"TheProofIsWaitedFor", S::kConfirming, kGround, S::kConfirming, X::kNone, R::kNone, true},
    A{"ConfirmedLateIsConfirmed", S::kConfirming, without(kGround, kSwitchSpaced) | kDeviceOurs | kTimeOver,
      S::kConfirming, X::kNone, R::kNone, true},
    A{"VirtualRcIsOn", S::kEnabling, kAir, S::kInControl, X::kNone, R::kGranted},
    A{"VirtualRcIsOnAtTheLastMoment", S::kEnabling, kAir | kTimeOver, S::kInControl, X::kNone, R::kGranted},
    A{"VirtualRcDoesNotCome", S::kEnabling, without(kAir, kVirtualRcOn) | kTimeOver, S::kConfirming, X::kNone,
      R::kGranted},
    A{"VirtualRcNeverComes", S::kEnabling, without(kAir, kVirtualRcOn | kSwitchesLeft) | kTimeOver, S::kSilent,
      X::kReleaseControl, R::kVirtualRcRefused},
    A{"VirtualRcIsWaitedFor", S::kEnabling, without(kAir, kVirtualRcOn), S::kEnabling, X::kNone, R::kNone, true},
};

}  // namespace m100::safety::situations
