// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "firmware/safety/authority_table.h"
#include "firmware/safety/failsafe.h"

namespace m100::safety::situations {

// The required answers of both tables in each situation, written by hand from the promises, not from the tables. A row
// that is deleted, changed or moved changes at least one answer. transitions_test.cpp also checks the reverse: for
// every row there must be a situation that only this row answers.

struct FailsafeSituation {
  const char* name;
  FailsafeState failsafe_state;
  FailsafeCondition conditions;
  FailsafeState after;
  FailsafeReason why = FailsafeReason::kNone;  ///< kNone: no step is made
};

inline constexpr FailsafeCondition kWell =
    FailsafeCondition::kCommandable | FailsafeCondition::kFresh | FailsafeCondition::kRecovered;
inline constexpr FailsafeCondition kBlind = FailsafeCondition::kCommandable;  ///< control is ours, and the pose is old

inline constexpr auto kFailsafeSituations = [] {
  using enum FailsafeCondition;
  using L = FailsafeSituation;
  using R = FailsafeState;
  using C = FailsafeReason;
  return std::array{
      L{"ThePilotTakesAHealthyFlight", R::kNominal, kFresh | kRecovered, R::kSilent, C::kControlGone},
      L{"ThePilotTakesACoastingFlight", R::kCoast, kNone, R::kSilent, C::kControlGone},
      L{"ThePilotTakesALevelledFlight", R::kLevel, kFresh | kRecovered, R::kSilent, C::kControlGone},
      L{"ThePilotTakesAFlightThatIsGivenBack", R::kRelease, kNone, R::kSilent, C::kControlGone},
      L{"ThePilotComesBeforeTheOperator", R::kNominal, kOperatorReleases | kTelemetryDead, R::kSilent, C::kControlGone},
      L{"ThePilotComesBeforeTheEndOfNeutral", R::kRelease, kNeutralOver, R::kSilent, C::kControlGone},
      L{"NeutralWasLongEnough", R::kRelease, kBlind | kNeutralOver, R::kSilent, C::kNeutralOver},
      L{"NeutralIsNotCutShort", R::kRelease, kWell | kOperatorEngages, R::kRelease},
      L{"TheOperatorGivesAHealthyFlightBack", R::kNominal, kWell | kOperatorReleases, R::kRelease, C::kGivenBack},
      L{"TheOperatorGivesACoastingFlightBack", R::kCoast, kBlind | kOperatorReleases, R::kRelease, C::kGivenBack},
      L{"TheOperatorGivesALevelledFlightBack", R::kLevel, kBlind | kOperatorReleases, R::kRelease, C::kGivenBack},
      L{"GivingBackComesBeforeAnUnsoundCommand", R::kNominal, kWell | kOperatorReleases | kCommandInvalid, R::kRelease,
        C::kGivenBack},
      L{"GivingBackComesBeforeEngaging", R::kLevel, kWell | kOperatorReleases | kOperatorEngages, R::kRelease,
        C::kGivenBack},
      L{"TheAutopilotFallsSilentInAHealthyFlight", R::kNominal, kWell | kTelemetryDead, R::kRelease,
        C::kTelemetrySilent},
      L{"TheAutopilotFallsSilentWhileCoasting", R::kCoast, kBlind | kTelemetryDead, R::kRelease, C::kTelemetrySilent},
      L{"TheAutopilotFallsSilentWhileLevel", R::kLevel, kBlind | kTelemetryDead, R::kRelease, C::kTelemetrySilent},
      L{"SilenceComesBeforeALostEstimate", R::kCoast, kBlind | kTelemetryDead | kEstimateLost, R::kRelease,
        C::kTelemetrySilent},
      L{"LevelWasLongEnough", R::kLevel, kBlind | kLevelOver, R::kRelease, C::kLevelOver},
      L{"AHealthyPoseDoesNotKeepALevelledFlight", R::kLevel, kWell | kLevelOver, R::kRelease, C::kLevelOver},
      L{"AnOrderWithoutAPoseDoesNotKeepALevelledFlight", R::kLevel, kBlind | kLevelOver | kOperatorEngages, R::kRelease,
        C::kLevelOver},
      L{"AnOrderThatCannotBeObeyedDoesNotKeepIt", R::kLevel, kWell | kLevelOver | kOperatorEngages | kEstimateLost,
        R::kRelease, C::kLevelOver},
      L{"TheOperatorTakesALevelledFlightAtTheLastMoment", R::kLevel, kWell | kLevelOver | kOperatorEngages, R::kNominal,
        C::kEngaged},
      L{"LevelLastsItsTime", R::kLevel, kWell, R::kLevel},
      L{"TheLawGoesMad", R::kNominal, kWell | kCommandInvalid, R::kLevel, C::kCommandInvalid},
      L{"TheLawGoesMadWhileCoasting", R::kCoast, kBlind | kCommandInvalid, R::kLevel, C::kCommandInvalid},
      L{"TheEstimateIsLost", R::kNominal, kWell | kEstimateLost, R::kLevel, C::kEstimateLost},
      L{"TheEstimateIsLostWithThePose", R::kNominal, kBlind | kEstimateLost, R::kLevel, C::kEstimateLost},
      L{"TheEstimateIsLostWhileCoasting", R::kCoast, kBlind | kEstimateLost, R::kLevel, C::kEstimateLost},
      L{"AFreshPoseDoesNotHelpALostEstimate", R::kCoast, kWell | kEstimateLost, R::kLevel, C::kEstimateLost},
      L{"TheFenceIsLeft", R::kNominal, kWell | kOutsideFence, R::kLevel, C::kFenceLeft},
      L{"TheFenceIsLeftWithThePose", R::kNominal, kBlind | kOutsideFence, R::kLevel, C::kFenceLeft},
      L{"TheFenceIsLeftWhileCoasting", R::kCoast, kWell | kOutsideFence, R::kLevel, C::kFenceLeft},
      L{"TheWindIsStrongerThanTheAircraft", R::kNominal, kWell | kAuthorityExceeded, R::kLevel, C::kAuthorityExceeded},
      L{"ItSwingsOnUnderTheCalmLaw", R::kNominal, kWell | kLimitCycle | kLimitCyclePersists, R::kLevel, C::kLimitCycle},
      L{"ItSwings", R::kNominal, kWell | kLimitCycle, R::kNominal},
      L{"AHealthyFlightLosesControlOfTheAircraft", R::kNominal, kWell | kFlightFailure, R::kSilent, C::kFlightFailure},
      L{"ACoastingFlightLosesControlOfTheAircraft", R::kCoast, kBlind | kFlightFailure, R::kSilent, C::kFlightFailure},
      L{"ALevelledFlightLosesControlOfTheAircraft", R::kLevel, kWell | kFlightFailure, R::kSilent, C::kFlightFailure},
      L{"AFailureDoesNotWaitForTheEndOfNeutral", R::kRelease, kBlind | kFlightFailure, R::kSilent, C::kFlightFailure},
      L{"AFailureEndsATask", R::kLevel, kBlind | kTaskFlies | kFlightFailure, R::kSilent, C::kFlightFailure},
      L{"ThePilotComesBeforeAFailure", R::kNominal, kFresh | kFlightFailure, R::kSilent, C::kControlGone},
      L{"TheAircraftIsOnTheGround", R::kNominal, kWell | kOnGround, R::kSilent, C::kOnGround},
      L{"TheAircraftIsOnTheGroundWhileCoasting", R::kCoast, kBlind | kOnGround, R::kSilent, C::kOnGround},
      L{"TheAircraftIsOnTheGroundWhileLevel", R::kLevel, kBlind | kOnGround, R::kSilent, C::kOnGround},
      L{"ATaskMayBeginAndEndOnTheGround", R::kLevel, kBlind | kOnGround | kTaskFlies, R::kLevel},
      L{"ATaskIsOrderedOnTheGround", R::kSilent, kBlind | kOnGround | kTaskFlies, R::kLevel, C::kTask},
      L{"ALandingIsOrderedOnTheGround", R::kNominal, kWell | kOnGround | kTaskFlies, R::kLevel, C::kTask},
      L{"NoTaskAfterAFailure", R::kSilent, kBlind | kTaskFlies | kFlightFailure, R::kSilent},
      L{"NoStartOnTheGround", R::kSilent, kWell | kOperatorEngages | kOnGround, R::kSilent},
      L{"NoStartAfterAFailure", R::kSilent, kWell | kOperatorEngages | kFlightFailure, R::kSilent},
      L{"TheReserveToTheFenceIsSpent", R::kCoast, kBlind | kReserveSpent, R::kLevel, C::kReserveSpent},
      L{"AFreshPoseRenewsTheReserve", R::kCoast, kBlind | kFresh | kReserveSpent, R::kCoast},
      L{"CoastWasLongEnough", R::kCoast, kBlind | kCoastOver, R::kLevel, C::kCoastOver},
      L{"TenFreshPosesMayEndAfterTheTimeOfCoast", R::kCoast, kBlind | kFresh | kCoastOver, R::kCoast},
      L{"CoastLastsItsTime", R::kCoast, kBlind, R::kCoast},
      L{"ThePoseStaysAway", R::kNominal, kBlind, R::kCoast, C::kPoseOld},
      L{"AllIsWell", R::kNominal, kWell, R::kNominal},
      L{"AnOldPoseDoesNotWaitForTheOperator", R::kNominal, kBlind | kOperatorEngages, R::kCoast, C::kPoseOld},
      L{"ThePoseIsBack", R::kCoast, kWell, R::kNominal, C::kRecovered},
      L{"TheOperatorTakesALevelledFlight", R::kLevel, kWell | kOperatorEngages, R::kNominal, C::kEngaged},
      L{"NotWithoutAPose", R::kLevel, kBlind | kOperatorEngages, R::kLevel},
      L{"NotOutsideTheFence", R::kLevel, kWell | kOperatorEngages | kOutsideFence, R::kLevel},
      L{"NotWithoutAnEstimate", R::kLevel, kWell | kOperatorEngages | kEstimateLost, R::kLevel},
      L{"NotWithALawThatIsMad", R::kLevel, kWell | kOperatorEngages | kCommandInvalid, R::kLevel},
      L{"TheOperatorStartsTheFlight", R::kSilent, kWell | kOperatorEngages, R::kNominal, C::kEngaged},
      L{"NobodyStartsIt", R::kSilent, kWell, R::kSilent},
      L{"NotWithoutAuthority", R::kSilent, kFresh | kRecovered | kOperatorEngages, R::kSilent},
      L{"NoStartWithoutAPose", R::kSilent, kBlind | kFresh | kOperatorEngages, R::kSilent},
      L{"NoStartWithoutAnEstimate", R::kSilent, kWell | kOperatorEngages | kEstimateLost, R::kSilent},
      L{"NoStartWithALawThatIsMad", R::kSilent, kWell | kOperatorEngages | kCommandInvalid, R::kSilent},
      L{"ATakeOffBeginsLevel", R::kSilent, kBlind | kTaskFlies, R::kLevel, C::kTask},
      L{"TheLawWaitsForTheEndOfATakeOff", R::kSilent, kWell | kTaskFlies | kOperatorEngages, R::kLevel, C::kTask},
      L{"NoTaskWhereControlIsNotOurs", R::kSilent, kFresh | kRecovered | kTaskFlies, R::kSilent},
      L{"NoTaskThatTheOperatorTakesBack", R::kSilent, kBlind | kTaskFlies | kOperatorReleases, R::kSilent},
      L{"NoTaskOfASilentAutopilot", R::kSilent, kBlind | kTaskFlies | kTelemetryDead, R::kSilent},
      L{"ALandingTakesTheLawOut", R::kNominal, kWell | kTaskFlies, R::kLevel, C::kTask},
      L{"ALandingWhileCoasting", R::kCoast, kBlind | kTaskFlies, R::kLevel, C::kTask},
      L{"ALandingComesBeforeARecovery", R::kCoast, kWell | kTaskFlies, R::kLevel, C::kTask},
      L{"TheLawStaysOutWhileATaskFlies", R::kLevel, kWell | kTaskFlies | kOperatorEngages, R::kLevel},
      L{"AnOldPoseEndsNoTask", R::kLevel, kBlind | kTaskFlies, R::kLevel},
      L{"ThePilotEndsATask", R::kLevel, (kWell & ~kCommandable) | kTaskFlies, R::kSilent, C::kControlGone},
      L{"TheOperatorEndsATask", R::kLevel, kWell | kTaskFlies | kOperatorReleases, R::kRelease, C::kGivenBack},
      L{"ASilentAutopilotEndsATask", R::kLevel, kBlind | kTaskFlies | kTelemetryDead, R::kRelease, C::kTelemetrySilent},
      L{"NoStartOutsideTheFence", R::kSilent, kWell | kOperatorEngages | kOutsideFence, R::kSilent},
      L{"NoStartWhileGivingBack", R::kSilent, kWell | kOperatorEngages | kOperatorReleases, R::kSilent},
      L{"NoStartWithoutTelemetry", R::kSilent, kWell | kOperatorEngages | kTelemetryDead, R::kSilent},
  };
}();

/// The same for the authority table, in each of the given stages.
struct AuthoritySituation {
  const char* name;
  StageSet stages;
  AuthorityCondition conditions;
  AuthorityStage after;
  AuthorityAction action = AuthorityAction::kNone;
  AuthorityReason why = AuthorityReason::kNone;
  bool stays = false;  ///< no row answers; `after` has no meaning
};

/// On the ground and ready: the transmitter has control.
inline constexpr AuthorityCondition kGround = AuthorityCondition::kLinkAlive | AuthorityCondition::kItemsFresh |
                                              AuthorityCondition::kModeF | AuthorityCondition::kNeedsVirtualRc |
                                              AuthorityCondition::kRequestSpaced | AuthorityCondition::kTriesLeft |
                                              AuthorityCondition::kSwitchSpaced | AuthorityCondition::kSwitchesLeft;
/// In flight over Virtual RC.
inline constexpr AuthorityCondition kAir =
    kGround | AuthorityCondition::kDeviceOurs | AuthorityCondition::kVirtualRcOn | AuthorityCondition::kReleasePending;
inline constexpr AuthorityCondition kLinkUp = AuthorityCondition::kLinkAlive;

constexpr AuthorityCondition without(AuthorityCondition conditions, AuthorityCondition gone) {
  return conditions & ~gone;
}

extern const std::array<AuthoritySituation, 76> kAuthoritySituations;

}  // namespace m100::safety::situations
