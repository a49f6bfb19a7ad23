// SPDX-License-Identifier: BSD-3-Clause
// Writes both safety tables as Promela for Spin, from the constexpr arrays that fly: authority.pml includes the result.
// Usage: promela [--plant NAME]   (with a wrong row in a table, which the check has to find; --list prints the names)
//        promela --every-row      changes each number of each row, one after the other: the model has to change, too
#include <algorithm>
#include <array>
#include <cstdlib>
#include <iostream>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>

#include "firmware/safety/authority_table.h"
#include "firmware/safety/failsafe.h"
#include "firmware/safety/limits.h"

namespace {

using namespace m100::safety;

auto failsafe = kFailsafeTransitions;  // copies, which a planted row changes
auto authority = kAuthorityTable;

/// The first row of the table that satisfies the predicate; the planted defects change it.
template <typename Table, typename Is>
auto& first_row(Table& table, const Is& is) {
  const auto row = std::find_if(table.begin(), table.end(), is);
  if (row == table.end()) {
    std::cerr << "A planted row is no longer in the table.\n";
    std::exit(2);
  }
  return *row;
}
template <typename Is>
AuthorityTransition& authority_row(const Is& is) {
  return first_row(authority, is);
}
FailsafeTransition& failsafe_transition(FailsafeState from, FailsafeReason why) {
  return first_row(failsafe, [=](const FailsafeTransition& row) { return row.from == from && row.why == why; });
}
AuthorityTransition& row_because(AuthorityReason reason) {
  return authority_row([reason](const AuthorityTransition& row) { return row.reason == reason; });
}

struct Plant {
  std::string_view name;
  void (*change)();
};
constexpr std::array kPlants{
    Plant{"request_too_soon",
          [] {
            authority_row([](const AuthorityTransition& row) {
              return row.from.has(AuthorityStage::kSpacing) && row.with == AuthorityCondition::kRequestSpaced;
            }).with = AuthorityCondition::kNone;
          }},
    Plant{"ask_too_soon",
          [] {
            authority_row([](const AuthorityTransition& row) {
              return row.from.has(AuthorityStage::kReady) && row.action == AuthorityAction::kRequestControl;
            }).with = AuthorityCondition::kControlRequested;
          }},
    Plant{"mode_switch_unseen_in_control",
          [] {
            row_because(AuthorityReason::kLeftModeF).from = kAcquiring;
            failsafe_transition(FailsafeState::kNominal, FailsafeReason::kControlGone).from = FailsafeState::kSilent;
          }},
    Plant{"mode_switch_unseen_in_a_task",
          [] {
            row_because(AuthorityReason::kLeftModeF).from = kAcquiring;
            failsafe_transition(FailsafeState::kLevel, FailsafeReason::kControlGone).excludes =
                FailsafeCondition::kCommandable | FailsafeCondition::kTaskFlies;
          }},
    Plant{"virtual_rc_end_unseen", [] { row_because(AuthorityReason::kVirtualRcEnded).from = StageSet{}; }},
    Plant{"silence_unseen_in_control",
          [] {
            row_because(AuthorityReason::kLinkSilent).from = kAcquiring;
            authority_row([](const AuthorityTransition& row) {
              return row.without == AuthorityCondition::kItemsFresh;
            }).from = kAcquiring;
            failsafe_transition(FailsafeState::kNominal, FailsafeReason::kTelemetrySilent).to = FailsafeState::kNominal;
            failsafe_transition(FailsafeState::kCoast, FailsafeReason::kTelemetrySilent).to = FailsafeState::kCoast;
          }},
    Plant{"release_wish_ignored",
          [] {
            authority_row([](const AuthorityTransition& row) {
              return row.with == AuthorityCondition::kReleaseRequested;
            }).from = kAcquiring;
          }},
    Plant{"coast_never_ends",
          [] { failsafe_transition(FailsafeState::kCoast, FailsafeReason::kCoastOver).to = FailsafeState::kCoast; }},
    Plant{"level_never_ends",
          [] { failsafe_transition(FailsafeState::kLevel, FailsafeReason::kLevelOver).to = FailsafeState::kLevel; }},
    Plant{"order_keeps_a_levelled_flight",
          [] {
            failsafe_transition(FailsafeState::kLevel, FailsafeReason::kLevelOver).excludes =
                FailsafeCondition::kOperatorEngages;
          }},
    Plant{"ground_unseen",
          [] { failsafe_transition(FailsafeState::kNominal, FailsafeReason::kOnGround).to = FailsafeState::kNominal; }},
    Plant{
        "failure_unseen",
        [] { failsafe_transition(FailsafeState::kCoast, FailsafeReason::kFlightFailure).to = FailsafeState::kCoast; }},
    Plant{"release_never_ends",
          [] {
            failsafe_transition(FailsafeState::kRelease, FailsafeReason::kNeutralOver).to = FailsafeState::kRelease;
          }},
    Plant{"silence_asks_by_itself",
          [] {
            authority_row([](const AuthorityTransition& row) {
              return row.from.has(AuthorityStage::kSilent) && row.with == AuthorityCondition::kControlRequested;
            }).with = AuthorityCondition::kLinkAlive;
            authority_row([](const AuthorityTransition& row) {
              return row.from.has(AuthorityStage::kReady) && row.action == AuthorityAction::kRequestControl;
            }).with = AuthorityCondition::kRequestSpaced;
          }},
};

template <typename Number>
void define(std::string_view name, Number number) {
  std::cout << "#define " << name << " " << number << "\n";
}

void failsafe_conditions() {
  constexpr std::array kFailsafeConditions{std::pair{"COMMANDABLE", FailsafeCondition::kCommandable},
                                           std::pair{"OPERATOR_RELEASES", FailsafeCondition::kOperatorReleases},
                                           std::pair{"TELEMETRY_DEAD", FailsafeCondition::kTelemetryDead},
                                           std::pair{"UNSOUND", FailsafeCondition::kCommandInvalid},
                                           std::pair{"ESTIMATE_LOST", FailsafeCondition::kEstimateLost},
                                           std::pair{"FRESH", FailsafeCondition::kFresh},
                                           std::pair{"RECOVERED", FailsafeCondition::kRecovered},
                                           std::pair{"COAST_OVER", FailsafeCondition::kCoastOver},
                                           std::pair{"LEVEL_OVER", FailsafeCondition::kLevelOver},
                                           std::pair{"NEUTRAL_OVER", FailsafeCondition::kNeutralOver},
                                           std::pair{"OPERATOR_ENGAGES", FailsafeCondition::kOperatorEngages},
                                           std::pair{"OUTSIDE", FailsafeCondition::kOutsideFence},
                                           std::pair{"PLACE_LOST", FailsafeCondition::kAuthorityExceeded},
                                           std::pair{"TASK_FLIES", FailsafeCondition::kTaskFlies},
                                           std::pair{"SWINGS_ON", FailsafeCondition::kLimitCyclePersists},
                                           std::pair{"ON_GROUND", FailsafeCondition::kOnGround},
                                           std::pair{"FAILURE", FailsafeCondition::kFlightFailure}};
  for (const auto& [name, condition] : kFailsafeConditions) {
    define("L_" + std::string(name), bits_of(condition));
  }
}

void constants() {
  using enum AuthorityCondition;
  struct Named {
    std::string_view name;
    AuthorityCondition condition;
  };
  constexpr std::array kSigns{Named{"ASKED", kControlRequested},
                              Named{"RELEASE_ASKED", kReleaseRequested},
                              Named{"HEARD", kLinkAlive},
                              Named{"ITEMS_FRESH", kItemsFresh},
                              Named{"RESTARTED", kRestarted},
                              Named{"LOST_PUSH", kControlLostPush},
                              Named{"MODE_F", kModeF},
                              Named{"DEVICE_OURS", kDeviceOurs},
                              Named{"VIRTUAL_RC_ON", kVirtualRcOn},
                              Named{"NEEDS_VIRTUAL_RC", kNeedsVirtualRc},
                              Named{"DONE", kDone},
                              Named{"AGAIN", kSendAgain},
                              Named{"REFUSED", kRefused},
                              Named{"NO_ANSWER", kNoAnswer},
                              Named{"SPACED", kRequestSpaced},
                              Named{"TRIES_LEFT", kTriesLeft},
                              Named{"SWITCH_SPACED", kSwitchSpaced},
                              Named{"SWITCHES_LEFT", kSwitchesLeft},
                              Named{"TIME_OVER", kTimeOver},
                              Named{"OWED", kReleasePending},
                              Named{"OWN_STALL", kOwnStall},
                              Named{"PORT_BACK", kPortBack}};
  for (const Named& named : kSigns) {
    define("A_" + std::string(named.name), bits_of(named.condition));
  }
  for (std::size_t stage = 0; stage < kStageCount; ++stage) {
    define("stage_" + std::string(name(static_cast<AuthorityStage>(stage))), stage);
  }
  for (const FailsafeState failsafe_state : {FailsafeState::kSilent, FailsafeState::kNominal, FailsafeState::kCoast,
                                             FailsafeState::kLevel, FailsafeState::kRelease}) {
    define("failsafe_" + std::string(name(failsafe_state)), static_cast<int>(failsafe_state));
  }
  define("ACQUIRING_STAGES", kAcquiring.bits);
  define("HOLDING_STAGES", kHolding.bits);
  define("ACT_NONE", static_cast<int>(AuthorityAction::kNone));
  define("ACT_REQUEST", static_cast<int>(AuthorityAction::kRequestControl));
  define("ACT_SWITCH_ON", static_cast<int>(AuthorityAction::kSwitchVirtualRcOn));
  define("ACT_RELEASE", static_cast<int>(AuthorityAction::kReleaseControl));
  define("REQUESTS_PER_ACTION", static_cast<int>(kRequestsPerAction));
}

/// Times in the model's unit. Most are rounded down, so that the table acts earlier in the model than in flight; the
/// times of COAST and of LEVEL in motion are rounded up.
void times() {
  constexpr auto kUnit = std::chrono::milliseconds(250);
  const Limits limits;
  define("SPACING", kRequestSpacing / kUnit);
  define("GRANT_TIME", kGrantTime / kUnit);
  define("CONFIRM_TIME", kConfirmTime / kUnit);
  define("COAST_TIME", (limits.coast + kUnit - m100::core::Duration{1}) / kUnit);
  define("LEVEL_TIME", limits.level / kUnit);
  define("LEVEL_MOVING_TIME", (limits.level_moving + kUnit - m100::core::Duration{1}) / kUnit);
  define("NEUTRAL_TIME", limits.neutral / kUnit);
}

void tables() {
  std::cout << "\ninline match_authority() {\n  row = 255;\n";
  for (std::size_t i = 0; i < authority.size(); ++i) {
    const AuthorityTransition& row = authority[i];
    const bool ready = row.from.has(AuthorityStage::kReady) && row.to == AuthorityStage::kReady;
    const bool port = all(row.with, AuthorityCondition::kPortBack);
    std::cout << "  if :: row == 255 && ((" << row.from.bits << " >> stage) & 1) && (conditions & " << bits_of(row.with)
              << ") == " << bits_of(row.with) << " && !(conditions & " << bits_of(row.without) << ") -> row = " << i
              << "; to = " << static_cast<int>(row.to) << "; action = " << static_cast<int>(row.action)
              << "; ends_ask = " << (ready || port ? 1 : 0) << " :: else fi;\n";
  }
  std::cout << "}\n\ninline match_failsafe() {\n  row = 255; to = failsafe_state;\n";
  for (std::size_t i = 0; i < failsafe.size(); ++i) {
    const FailsafeTransition& row = failsafe[i];
    std::cout << "  if :: row == 255 && failsafe_state == " << static_cast<int>(row.from) << " && (conditions & "
              << bits_of(row.needs) << ") == " << bits_of(row.needs) << " && !(conditions & " << bits_of(row.excludes)
              << ") -> row = " << i << "; to = " << static_cast<int>(row.to) << " :: else fi;\n";
  }
  std::cout << "}\n";
}

void model() {
  std::cout << "/* Written by promela.cpp from firmware/safety/failsafe.h and authority_table.h. */\n";
  failsafe_conditions();
  constants();
  times();
  tables();
}

std::string model_text() {
  std::ostringstream text;
  std::streambuf* const out = std::cout.rdbuf(text.rdbuf());
  model();
  std::cout.rdbuf(out);
  return text.str();
}

/// Changes one number of a row by one bit and restores it. @returns whether the model changed.
template <typename Number>
bool shows(Number& number, const std::string& sound) {
  const Number was = number;
  number = static_cast<Number>(static_cast<unsigned>(was) ^ 1U);
  const bool changed = model_text() != sound;
  number = was;
  return changed;
}
bool shows(StageSet& stages, const std::string& sound) { return shows(stages.bits, sound); }

/// Covers the fields that decide; a row's reason is only shown to the operator.
int every_row() {
  const std::string sound = model_text();
  std::size_t numbers = 0, unseen = 0;
  const auto look = [&](const char* table, std::size_t row, auto&... all) {
    const bool seen = (shows(all, sound) && ...);
    numbers += sizeof...(all);
    unseen += seen ? 0U : 1U;
    if (!seen) {
      std::cout << table << " row " << row << ": a field was changed, but the model did not change\n";
    }
  };
  for (std::size_t i = 0; i < authority.size(); ++i) {
    AuthorityTransition& row = authority.at(i);
    look("authority", i, row.from, row.with, row.without, row.to, row.action);
  }
  for (std::size_t i = 0; i < failsafe.size(); ++i) {
    FailsafeTransition& row = failsafe.at(i);
    look("failsafe", i, row.from, row.needs, row.excludes, row.to);
  }
  std::cout << authority.size() + failsafe.size() << " rows, " << numbers << " numbers, " << unseen
            << " rows missing in the model\n";
  return unseen == 0 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string_view option = argc > 1 ? argv[1] : "";
  if (option == "--list") {
    for (const Plant& plant : kPlants) {
      std::cout << plant.name << "\n";
    }
    return 0;
  }
  if (option == "--plant") {
    bool planted = false;
    for (const Plant& plant : kPlants) {
      if (argc > 2 && plant.name == argv[2]) {
        plant.change();
        planted = true;
      }
    }
    if (!planted) {
      std::cerr << "Unknown planted row; --list names them.\n";
      return 2;
    }
  }
  if (option == "--every-row") {
    return every_row();
  }
  model();
  return 0;
}
