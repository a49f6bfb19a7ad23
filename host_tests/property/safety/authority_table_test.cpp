// SPDX-License-Identifier: BSD-3-Clause
// Properties of the authority table alone, for any behaviour of the world.
#include "firmware/safety/authority_table.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <deque>
#include <random>

namespace m100::safety {
namespace {

/// Exhaustive check of the table: a loss ends control, whatever other signs are set at the same time.
TEST(AuthorityTable, WhateverElseIsTrueALossEndsControl) {
  RecordProperty("promise", "R4");
  constexpr AuthoritySign kFlying =
      AuthoritySign::kHeard | AuthoritySign::kItemsFresh | AuthoritySign::kModeF | AuthoritySign::kDeviceOurs;
  constexpr AuthoritySign kLosses =
      AuthoritySign::kRestarted | AuthoritySign::kLostPush | AuthoritySign::kOwnStall | AuthoritySign::kNoAnswer;
  for (std::uint32_t bits = 0; bits < (1U << 24U); ++bits) {
    const AuthoritySign signs = static_cast<AuthoritySign>(bits);
    const bool lost = !all(signs, kFlying) || any(signs, kLosses) ||
                      (any(signs, AuthoritySign::kNeedsVirtualRc) && !any(signs, AuthoritySign::kVirtualRcOn));
    const Stage after = next(Stage::kInControl, signs);
    ASSERT_EQ(next(Stage::kInControl, signs | AuthoritySign::kPortBack), Stage::kListening) << std::hex << bits;
    if (lost) {
      ASSERT_TRUE(after == Stage::kSilent || after == Stage::kSilentCold) << std::hex << bits;
    } else {
      ASSERT_EQ(after, any(signs, AuthoritySign::kReleaseAsked) ? Stage::kReleasing : Stage::kInControl)
          << std::hex << bits;
    }
  }
}

/// In every stage on the way to control, a loss leads to silence, whatever other signs are set.
TEST(AuthorityTable, ALossOnTheWayToControlEndsTheAttempt) {
  for (const Stage stage : {Stage::kObtaining, Stage::kSpacing, Stage::kConfirming, Stage::kEnabling}) {
    for (std::uint32_t bits = 0; bits < (1U << 22U); ++bits) {  // no row of these stages needs kOwed
      const AuthoritySign signs = static_cast<AuthoritySign>(bits);
      const bool lost = !all(signs, AuthoritySign::kHeard | AuthoritySign::kItemsFresh | AuthoritySign::kModeF) ||
                        any(signs, AuthoritySign::kRestarted | AuthoritySign::kLostPush);
      const Stage after = next(stage, lost ? signs : signs | AuthoritySign::kOwnStall);
      ASSERT_TRUE(after == Stage::kSilent || after == Stage::kSilentCold) << name(stage) << " " << std::hex << bits;
    }
  }
}

/// Random signs of telemetry and operator, a hundred times a second.
TEST(AuthorityTable, GivingBackIsRepeatedAtMostFiveTimesASecondAndRequestsEveryTwo) {
  RecordProperty("promise", "R4");
  constexpr core::Duration kTick = std::chrono::milliseconds(10);
  std::mt19937_64 random(15);
  AuthorityState state;
  std::deque<int> last_second;  // ticks at which control was given back
  core::Duration since_request = kRequestSpacing;
  int releases = 0;
  std::size_t most = 0;
  for (int i = 0; i < 400000; ++i) {
    // Levels last for a while; edges are rare.
    const auto levels = static_cast<AuthoritySign>((random() | random()) & (i % 50 < 40 ? 0x7CCU : 0x7CCU & random()));
    const auto edges = static_cast<AuthoritySign>(random() % 8 == 0 ? 1U << (random() % 25U) : 0U);
    const AuthorityStep made = step(state, levels | edges, kTick);
    state = made.state;
    since_request += kTick;
    if (made.action == Action::kReleaseControl) {
      while (!last_second.empty() && (i - last_second.front()) * kTick >= std::chrono::seconds(1)) {
        last_second.pop_front();
      }
      last_second.push_back(i);
      ASSERT_LE(last_second.size(), 5U) << "step " << i;
      most = std::max(most, last_second.size());
      ++releases;
    } else if (made.action == Action::kRequestControl) {
      ASSERT_GE(since_request, kRequestSpacing) << "step " << i;
      since_request = core::Duration{0};
    }
  }
  EXPECT_GT(releases, 1000) << "too few releases for a test";
  EXPECT_EQ(most, 5U);
}

TEST(AuthorityTable, EveryReasonAndEveryStageHasAName) {
  for (std::size_t stage = 0; stage < kStageCount; ++stage) {
    EXPECT_FALSE(name(static_cast<Stage>(stage)).empty());
  }
  for (const AuthorityRow& row : kAuthorityTable) {
    EXPECT_FALSE(name(row.reason).empty());
    const bool is_end = row.to == Stage::kSilent || row.to == Stage::kSilentCold || row.to == Stage::kPausing;
    EXPECT_EQ(is_end && remedy(row.reason).empty(), false) << name(row.reason) << " has no remedy for the operator";
  }
}

}  // namespace
}  // namespace m100::safety
