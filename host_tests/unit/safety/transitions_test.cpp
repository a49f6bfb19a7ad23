// SPDX-License-Identifier: BSD-3-Clause
// Every row of both safety tables must answer a situation, and a test must fail without it.
#include <gtest/gtest.h>

#include <string>

#include "host_tests/unit/safety/situations.h"

namespace m100::safety {
namespace {

using situations::AuthoritySituation;
using situations::FailsafeSituation;
using situations::kAuthoritySituations;
using situations::kFailsafeSituations;

constexpr std::array kEveryStageOnce{AuthorityStage::kListening,  AuthorityStage::kRequestingVersion,
                                     AuthorityStage::kActivating, AuthorityStage::kSettingRates,
                                     AuthorityStage::kPausing,    AuthorityStage::kAwaitingTelemetry,
                                     AuthorityStage::kReady,      AuthorityStage::kObtaining,
                                     AuthorityStage::kSpacing,    AuthorityStage::kConfirming,
                                     AuthorityStage::kEnabling,   AuthorityStage::kInControl,
                                     AuthorityStage::kReleasing,  AuthorityStage::kSilent,
                                     AuthorityStage::kSilentCold};
static_assert(kEveryStageOnce.size() == kStageCount);

std::string words(std::size_t row) { return row < kAuthorityTable.size() ? "row " + std::to_string(row) : "no row"; }

// The situations, in the order of the promises. They do not read the tables' rows, so a missing row is found.

class SituationOfTheFailsafe : public ::testing::TestWithParam<FailsafeSituation> {};

TEST_P(SituationOfTheFailsafe, IsAnsweredAsThePromisesSay) {
  RecordProperty("promise", "R4, R12");
  const FailsafeSituation& reported = GetParam();
  const std::size_t row = row_number(reported.failsafe_state, reported.conditions);
  EXPECT_EQ(name(next_failsafe_state(reported.failsafe_state, reported.conditions)), name(reported.after));
  EXPECT_EQ(name(row < kFailsafeTransitions.size() ? kFailsafeTransitions[row].why : FailsafeReason::kNone),
            name(reported.why))
      << "row " << row;
}
INSTANTIATE_TEST_SUITE_P(All, SituationOfTheFailsafe, ::testing::ValuesIn(kFailsafeSituations),
                         [](const auto& tested) { return tested.param.name; });

class SituationOfAuthority : public ::testing::TestWithParam<AuthoritySituation> {};

TEST_P(SituationOfAuthority, IsAnsweredAsThePromisesSay) {
  RecordProperty("promise", "R4, R15");
  const AuthoritySituation& reported = GetParam();
  for (const AuthorityStage stage : kEveryStageOnce) {
    if (!reported.stages.has(stage)) {
      continue;
    }
    const std::size_t number = match_number(stage, reported.conditions);
    SCOPED_TRACE(std::string(name(stage)) + ": " + words(number));
    EXPECT_EQ(number == kAuthorityTable.size(), reported.stays);
    if (number < kAuthorityTable.size() && !reported.stays) {
      const AuthorityTransition& row = kAuthorityTable[number];
      EXPECT_EQ(name(row.to), name(reported.after));
      EXPECT_EQ(row.action, reported.action);
      EXPECT_EQ(name(row.reason), name(reported.why));
    }
  }
}
INSTANTIATE_TEST_SUITE_P(All, SituationOfAuthority, ::testing::ValuesIn(kAuthoritySituations),
                         [](const auto& tested) { return tested.param.name; });

// One test per row, made from the tables. A row that is the only answer to no situation is either unnecessary, or its
// loss would not be noticed.

/// The row that answers when row `gone` is missing.
template <typename Row, std::size_t kRows, typename Matches>
std::size_t answer_without(const std::array<Row, kRows>& table, std::size_t gone, const Matches& matches) {
  for (std::size_t i = 0; i < kRows; ++i) {
    if (i != gone && matches(table[i])) {
      return i;
    }
  }
  return kRows;
}

class FailsafeTransitionRow : public ::testing::TestWithParam<std::size_t> {};

TEST_P(FailsafeTransitionRow, HasASituationThatItAloneAnswers) {
  const FailsafeTransition& row = kFailsafeTransitions[GetParam()];
  int situations_found = 0;
  for (const FailsafeSituation& reported : kFailsafeSituations) {
    const auto matches = [&reported](const FailsafeTransition& other) {
      return other.from == reported.failsafe_state && all(reported.conditions, other.needs) &&
             !any(reported.conditions, other.excludes);
    };
    const std::size_t other = answer_without(kFailsafeTransitions, GetParam(), matches);
    const bool same = other < kFailsafeTransitions.size() && kFailsafeTransitions[other].to == row.to &&
                      kFailsafeTransitions[other].why == row.why;
    situations_found += row_number(reported.failsafe_state, reported.conditions) == GetParam() && !same ? 1 : 0;
  }
  EXPECT_GT(situations_found, 0) << "from " << name(row.from) << " to " << name(row.to) << ", " << name(row.why)
                                 << ": add the situation to situations.h";
}
INSTANTIATE_TEST_SUITE_P(Every, FailsafeTransitionRow, ::testing::Range(std::size_t{0}, kFailsafeTransitions.size()),
                         [](const auto& tested) {
                           const FailsafeTransition& row = kFailsafeTransitions[tested.param];
                           return std::to_string(tested.param) + "_" + std::string(name(row.from)) + "_" +
                                  std::string(name(row.why));
                         });

class RowOfAuthority : public ::testing::TestWithParam<std::size_t> {};

TEST_P(RowOfAuthority, HasASituationThatItAloneAnswersInEveryStageOfIt) {
  const AuthorityTransition& row = kAuthorityTable[GetParam()];
  for (const AuthorityStage stage : kEveryStageOnce) {
    int situations_found = 0;
    for (const AuthoritySituation& reported : kAuthoritySituations) {
      const auto matches = [&reported, stage](const AuthorityTransition& other) {
        return other.from.has(stage) && all(reported.conditions, other.with) &&
               !any(reported.conditions, other.without);
      };
      const std::size_t number = answer_without(kAuthorityTable, GetParam(), matches);
      bool same = false;
      if (number < kAuthorityTable.size()) {
        const AuthorityTransition& other = kAuthorityTable[number];
        same = other.to == row.to && other.action == row.action && other.reason == row.reason;
      }
      situations_found +=
          reported.stages.has(stage) && match_number(stage, reported.conditions) == GetParam() && !same ? 1 : 0;
    }
    EXPECT_EQ(situations_found > 0, row.from.has(stage))
        << "in " << name(stage) << ", to " << name(row.to) << ", " << name(row.reason)
        << ": add the situation to authority_situations.cpp";
  }
}
INSTANTIATE_TEST_SUITE_P(Every, RowOfAuthority, ::testing::Range(std::size_t{0}, kAuthorityTable.size()),
                         [](const auto& tested) {
                           const AuthorityTransition& row = kAuthorityTable[tested.param];
                           return std::to_string(tested.param) + "_to_" + std::to_string(static_cast<int>(row.to));
                         });

// R4: at most five releases in a second, the first five 0.1 s apart. Catches a count that begins anew after less than a
// second without one, or after more.
TEST(AuthorityStep, SpacesReleasesAndBeginsAnewAfterAWholeSecondWithoutOne) {
  constexpr AuthorityCondition kOurs = situations::kGround | AuthorityCondition::kDeviceOurs;
  AuthorityState state{.stage = AuthorityStage::kSilent};
  const auto ms_to_release = [&state] {
    int ms = 0;
    AuthorityStep made = step(state, kOurs, core::Duration{0});
    for (; made.action != AuthorityAction::kReleaseControl && ms < 2000; ++ms) {
      made = step(made.state, kOurs, std::chrono::milliseconds(1));
    }
    state = made.state;
    return ms;
  };
  for (const int ms : {0, 100, 100, 100, 100, 600, 200, 200}) {
    EXPECT_EQ(ms_to_release(), ms);
  }
  for (const int pause_ms : {999, 1000}) {
    state = step(state, situations::kGround, std::chrono::milliseconds(pause_ms)).state;
    EXPECT_EQ(ms_to_release(), 0);
    EXPECT_EQ(ms_to_release(), pause_ms < 1000 ? 200 : 100) << pause_ms;
  }
  state.requests = state.switches = kRequestsPerAction;
  state = step(state, situations::kGround | AuthorityCondition::kControlRequested, core::Duration{0}).state;
  EXPECT_EQ(state.requests + state.switches, 0) << "an order has all its tries, whatever the one before it used";
}

}  // namespace
}  // namespace m100::safety
