// SPDX-License-Identifier: BSD-3-Clause
// Writes both safety tables as Promela for Spin, from the constexpr arrays that fly: sticks.pml includes the result.
// Usage: promela [--plant NAME]   (with a wrong row in a table, which the check has to find; --list prints the names)
//        promela --every-row      changes each number of each row, one after the other: the model has to change, too
#include <array>
#include <cstdlib>
#include <iostream>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>

#include "firmware/safety/authority_table.h"
#include "firmware/safety/ladder.h"
#include "firmware/safety/limits.h"

namespace {

using namespace m100::safety;

auto ladder = kLadder;  // copies, which a planted row changes
auto authority = kAuthorityTable;

/// The first row of the authority table that satisfies the predicate; the planted defects change it.
template <typename Is>
AuthorityRow& authority_row(const Is& is) {
  for (AuthorityRow& row : authority) {
    if (is(row)) {
      return row;
    }
  }
  std::cerr << "A planted row is no longer in the table.\n";
  std::exit(2);
}
LadderRow& ladder_row(Rung from, Cause why) {
  for (LadderRow& row : ladder) {
    if (row.from == from && row.why == why) {
      return row;
    }
  }
  std::cerr << "A planted row is no longer in the table.\n";
  std::exit(2);
}
AuthorityRow& row_because(Reason reason) {
  return authority_row([reason](const AuthorityRow& row) { return row.reason == reason; });
}

struct Plant {
  std::string_view name;
  void (*change)();
};
constexpr std::array kPlants{
    Plant{"request_too_soon",
          [] {
            authority_row([](const AuthorityRow& row) {
              return row.from.has(Stage::kSpacing) && row.with == AuthoritySign::kSpaced;
            }).with = AuthoritySign::kNone;
          }},
    Plant{"ask_too_soon",
          [] {
            authority_row([](const AuthorityRow& row) {
              return row.from.has(Stage::kReady) && row.action == Action::kRequestControl;
            }).with = AuthoritySign::kAsked;
          }},
    Plant{"mode_switch_unseen_in_control",
          [] {
            row_because(Reason::kLeftModeF).from = kAcquiring;
            ladder_row(Rung::kNominal, Cause::kControlGone).from = Rung::kSilent;
          }},
    Plant{"mode_switch_unseen_in_a_task",
          [] {
            row_because(Reason::kLeftModeF).from = kAcquiring;
            ladder_row(Rung::kLevel, Cause::kControlGone).excludes = LadderSign::kCommandable | LadderSign::kTaskFlies;
          }},
    Plant{"virtual_rc_end_unseen", [] { row_because(Reason::kVirtualRcEnded).from = StageSet{}; }},
    Plant{"silence_unseen_in_control",
          [] {
            row_because(Reason::kLinkSilent).from = kAcquiring;
            authority_row([](const AuthorityRow& row) { return row.without == AuthoritySign::kItemsFresh; }).from =
                kAcquiring;
            ladder_row(Rung::kNominal, Cause::kTelemetrySilent).to = Rung::kNominal;
            ladder_row(Rung::kCoast, Cause::kTelemetrySilent).to = Rung::kCoast;
          }},
    Plant{"release_wish_ignored",
          [] {
            authority_row([](const AuthorityRow& row) { return row.with == AuthoritySign::kReleaseAsked; }).from =
                kAcquiring;
          }},
    Plant{"coast_never_ends", [] { ladder_row(Rung::kCoast, Cause::kCoastOver).to = Rung::kCoast; }},
    Plant{"level_never_ends", [] { ladder_row(Rung::kLevel, Cause::kLevelOver).to = Rung::kLevel; }},
    Plant{"order_keeps_a_levelled_flight",
          [] { ladder_row(Rung::kLevel, Cause::kLevelOver).excludes = LadderSign::kOperatorEngages; }},
    Plant{"release_never_ends", [] { ladder_row(Rung::kRelease, Cause::kNeutralOver).to = Rung::kRelease; }},
    Plant{"silence_asks_by_itself",
          [] {
            authority_row([](const AuthorityRow& row) {
              return row.from.has(Stage::kSilent) && row.with == AuthoritySign::kAsked;
            }).with = AuthoritySign::kHeard;
            authority_row([](const AuthorityRow& row) {
              return row.from.has(Stage::kReady) && row.action == Action::kRequestControl;
            }).with = AuthoritySign::kSpaced;
          }},
};

template <typename Number>
void define(std::string_view name, Number number) {
  std::cout << "#define " << name << " " << number << "\n";
}

void ladder_signs() {
  constexpr std::array kLadderSigns{std::pair{"COMMANDABLE", LadderSign::kCommandable},
                                    std::pair{"OPERATOR_RELEASES", LadderSign::kOperatorReleases},
                                    std::pair{"TELEMETRY_DEAD", LadderSign::kTelemetryDead},
                                    std::pair{"UNSOUND", LadderSign::kCommandUnsound},
                                    std::pair{"ESTIMATE_LOST", LadderSign::kEstimateLost},
                                    std::pair{"FRESH", LadderSign::kFresh},
                                    std::pair{"RECOVERED", LadderSign::kRecovered},
                                    std::pair{"COAST_OVER", LadderSign::kCoastOver},
                                    std::pair{"LEVEL_OVER", LadderSign::kLevelOver},
                                    std::pair{"NEUTRAL_OVER", LadderSign::kNeutralOver},
                                    std::pair{"OPERATOR_ENGAGES", LadderSign::kOperatorEngages},
                                    std::pair{"OUTSIDE", LadderSign::kOutside},
                                    std::pair{"PLACE_LOST", LadderSign::kPlaceLost},
                                    std::pair{"TASK_FLIES", LadderSign::kTaskFlies},
                                    std::pair{"SWINGS_ON", LadderSign::kSwingsOn}};
  for (const auto& [name, sign] : kLadderSigns) {
    define("L_" + std::string(name), bits_of(sign));
  }
}

void constants() {
  using enum AuthoritySign;
  struct Named {
    std::string_view name;
    AuthoritySign sign;
  };
  constexpr std::array kSigns{Named{"ASKED", kAsked},
                              Named{"RELEASE_ASKED", kReleaseAsked},
                              Named{"HEARD", kHeard},
                              Named{"ITEMS_FRESH", kItemsFresh},
                              Named{"RESTARTED", kRestarted},
                              Named{"LOST_PUSH", kLostPush},
                              Named{"MODE_F", kModeF},
                              Named{"DEVICE_OURS", kDeviceOurs},
                              Named{"VIRTUAL_RC_ON", kVirtualRcOn},
                              Named{"NEEDS_VIRTUAL_RC", kNeedsVirtualRc},
                              Named{"DONE", kDone},
                              Named{"AGAIN", kAgain},
                              Named{"REFUSED", kRefused},
                              Named{"NO_ANSWER", kNoAnswer},
                              Named{"SPACED", kSpaced},
                              Named{"TRIES_LEFT", kTriesLeft},
                              Named{"SWITCH_SPACED", kSwitchSpaced},
                              Named{"SWITCHES_LEFT", kSwitchesLeft},
                              Named{"TIME_OVER", kTimeOver},
                              Named{"OWED", kOwed},
                              Named{"OWN_STALL", kOwnStall},
                              Named{"PORT_BACK", kPortBack}};
  for (const Named& named : kSigns) {
    define("A_" + std::string(named.name), bits_of(named.sign));
  }
  for (std::size_t stage = 0; stage < kStageCount; ++stage) {
    define("stage_" + std::string(name(static_cast<Stage>(stage))), stage);
  }
  for (const Rung rung : {Rung::kSilent, Rung::kNominal, Rung::kCoast, Rung::kLevel, Rung::kRelease}) {
    define("rung_" + std::string(name(rung)), static_cast<int>(rung));
  }
  define("ACQUIRING_STAGES", kAcquiring.bits);
  define("HOLDING_STAGES", kHolding.bits);
  define("ACT_NONE", static_cast<int>(Action::kNone));
  define("ACT_REQUEST", static_cast<int>(Action::kRequestControl));
  define("ACT_SWITCH_ON", static_cast<int>(Action::kSwitchVirtualRcOn));
  define("ACT_RELEASE", static_cast<int>(Action::kReleaseControl));
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
    const AuthorityRow& row = authority[i];
    const bool ready = row.from.has(Stage::kReady) && row.to == Stage::kReady;
    const bool port = all(row.with, AuthoritySign::kPortBack);
    std::cout << "  if :: row == 255 && ((" << row.from.bits << " >> stage) & 1) && (signs & " << bits_of(row.with)
              << ") == " << bits_of(row.with) << " && !(signs & " << bits_of(row.without) << ") -> row = " << i
              << "; to = " << static_cast<int>(row.to) << "; action = " << static_cast<int>(row.action)
              << "; ends_ask = " << (ready || port ? 1 : 0) << " :: else fi;\n";
  }
  std::cout << "}\n\ninline match_ladder() {\n  row = 255; to = rung;\n";
  for (std::size_t i = 0; i < ladder.size(); ++i) {
    const LadderRow& row = ladder[i];
    std::cout << "  if :: row == 255 && rung == " << static_cast<int>(row.from) << " && (signs & " << bits_of(row.needs)
              << ") == " << bits_of(row.needs) << " && !(signs & " << bits_of(row.excludes) << ") -> row = " << i
              << "; to = " << static_cast<int>(row.to) << " :: else fi;\n";
  }
  std::cout << "}\n";
}

void model() {
  std::cout << "/* Written by promela.cpp from firmware/safety/ladder.h and authority_table.h. */\n";
  ladder_signs();
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
    AuthorityRow& row = authority.at(i);
    look("authority", i, row.from, row.with, row.without, row.to, row.action);
  }
  for (std::size_t i = 0; i < ladder.size(); ++i) {
    LadderRow& row = ladder.at(i);
    look("ladder", i, row.from, row.needs, row.excludes, row.to);
  }
  std::cout << authority.size() + ladder.size() << " rows, " << numbers << " numbers, " << unseen
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
