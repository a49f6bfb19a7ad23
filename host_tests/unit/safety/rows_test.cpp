// SPDX-License-Identifier: BSD-3-Clause
// Every row of both safety tables must answer a situation, and a test must fail without it.
#include <gtest/gtest.h>

#include <string>

#include "host_tests/unit/safety/situations.h"

namespace m100::safety {
namespace {

using situations::AuthoritySituation;
using situations::kAuthoritySituations;
using situations::kLadderSituations;
using situations::LadderSituation;

constexpr std::array kEveryStageOnce{
    Stage::kListening,         Stage::kAskingVersion, Stage::kActivating, Stage::kSettingRates, Stage::kPausing,
    Stage::kAwaitingTelemetry, Stage::kReady,         Stage::kObtaining,  Stage::kSpacing,      Stage::kConfirming,
    Stage::kEnabling,          Stage::kInControl,     Stage::kReleasing,  Stage::kSilent,       Stage::kSilentCold};
static_assert(kEveryStageOnce.size() == kStageCount);

std::string words(std::size_t row) { return row < kAuthorityTable.size() ? "row " + std::to_string(row) : "no row"; }

// The situations, in the order of the promises. They do not read the tables' rows, so a missing row is found.

class SituationOfTheLadder : public ::testing::TestWithParam<LadderSituation> {};

TEST_P(SituationOfTheLadder, IsAnsweredAsThePromisesSay) {
  RecordProperty("promise", "R4, R12");
  const LadderSituation& told = GetParam();
  const std::size_t row = row_number(told.rung, told.signs);
  EXPECT_EQ(name(next_rung(told.rung, told.signs)), name(told.after));
  EXPECT_EQ(name(row < kLadder.size() ? kLadder[row].why : Cause::kNone), name(told.why)) << "row " << row;
}
INSTANTIATE_TEST_SUITE_P(All, SituationOfTheLadder, ::testing::ValuesIn(kLadderSituations),
                         [](const auto& tested) { return tested.param.name; });

class SituationOfAuthority : public ::testing::TestWithParam<AuthoritySituation> {};

TEST_P(SituationOfAuthority, IsAnsweredAsThePromisesSay) {
  RecordProperty("promise", "R4, R15");
  const AuthoritySituation& told = GetParam();
  for (const Stage stage : kEveryStageOnce) {
    if (!told.stages.has(stage)) {
      continue;
    }
    const std::size_t number = match_number(stage, told.signs);
    SCOPED_TRACE(std::string(name(stage)) + ": " + words(number));
    EXPECT_EQ(number == kAuthorityTable.size(), told.stays);
    if (number < kAuthorityTable.size() && !told.stays) {
      const AuthorityRow& row = kAuthorityTable[number];
      EXPECT_EQ(name(row.to), name(told.after));
      EXPECT_EQ(row.action, told.action);
      EXPECT_EQ(name(row.reason), name(told.why));
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

class RowOfTheLadder : public ::testing::TestWithParam<std::size_t> {};

TEST_P(RowOfTheLadder, HasASituationThatItAloneAnswers) {
  const LadderRow& row = kLadder[GetParam()];
  int situations_found = 0;
  for (const LadderSituation& told : kLadderSituations) {
    const auto matches = [&told](const LadderRow& other) {
      return other.from == told.rung && all(told.signs, other.needs) && !any(told.signs, other.excludes);
    };
    const std::size_t other = answer_without(kLadder, GetParam(), matches);
    const bool same = other < kLadder.size() && kLadder[other].to == row.to && kLadder[other].why == row.why;
    situations_found += row_number(told.rung, told.signs) == GetParam() && !same ? 1 : 0;
  }
  EXPECT_GT(situations_found, 0) << "from " << name(row.from) << " to " << name(row.to) << ", " << name(row.why)
                                 << ": add the situation to situations.h";
}
INSTANTIATE_TEST_SUITE_P(Every, RowOfTheLadder, ::testing::Range(std::size_t{0}, kLadder.size()),
                         [](const auto& tested) {
                           const LadderRow& row = kLadder[tested.param];
                           return std::to_string(tested.param) + "_" + std::string(name(row.from)) + "_" +
                                  std::string(name(row.why));
                         });

class RowOfAuthority : public ::testing::TestWithParam<std::size_t> {};

TEST_P(RowOfAuthority, HasASituationThatItAloneAnswersInEveryStageOfIt) {
  const AuthorityRow& row = kAuthorityTable[GetParam()];
  for (const Stage stage : kEveryStageOnce) {
    int situations_found = 0;
    for (const AuthoritySituation& told : kAuthoritySituations) {
      const auto matches = [&told, stage](const AuthorityRow& other) {
        return other.from.has(stage) && all(told.signs, other.with) && !any(told.signs, other.without);
      };
      const std::size_t number = answer_without(kAuthorityTable, GetParam(), matches);
      bool same = false;
      if (number < kAuthorityTable.size()) {
        const AuthorityRow& other = kAuthorityTable[number];
        same = other.to == row.to && other.action == row.action && other.reason == row.reason;
      }
      situations_found += told.stages.has(stage) && match_number(stage, told.signs) == GetParam() && !same ? 1 : 0;
    }
    EXPECT_EQ(situations_found > 0, row.from.has(stage))
        << "in " << name(stage) << ", to " << name(row.to) << ", " << name(row.reason)
        << ": add the situation to authority_situations.cpp";
  }
}
INSTANTIATE_TEST_SUITE_P(Every, RowOfAuthority, ::testing::Range(std::size_t{0}, kAuthorityTable.size()),
                         [](const auto& tested) {
                           const AuthorityRow& row = kAuthorityTable[tested.param];
                           return std::to_string(tested.param) + "_to_" + std::to_string(static_cast<int>(row.to));
                         });

}  // namespace
}  // namespace m100::safety
