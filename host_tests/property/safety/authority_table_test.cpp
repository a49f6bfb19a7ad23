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
  constexpr AuthorityCondition kFlying = AuthorityCondition::kLinkAlive | AuthorityCondition::kItemsFresh |
                                         AuthorityCondition::kModeF | AuthorityCondition::kDeviceOurs;
  constexpr AuthorityCondition kLosses = AuthorityCondition::kRestarted | AuthorityCondition::kControlLostPush |
                                         AuthorityCondition::kOwnStall | AuthorityCondition::kNoAnswer;
  for (std::uint32_t bits = 0; bits < (1U << 24U); ++bits) {
    const AuthorityCondition conditions = static_cast<AuthorityCondition>(bits);
    const bool lost =
        !all(conditions, kFlying) || any(conditions, kLosses) ||
        (any(conditions, AuthorityCondition::kNeedsVirtualRc) && !any(conditions, AuthorityCondition::kVirtualRcOn));
    const AuthorityStage after = next(AuthorityStage::kInControl, conditions);
    ASSERT_EQ(next(AuthorityStage::kInControl, conditions | AuthorityCondition::kPortBack), AuthorityStage::kListening)
        << std::hex << bits;
    if (lost) {
      ASSERT_TRUE(after == AuthorityStage::kSilent || after == AuthorityStage::kSilentCold) << std::hex << bits;
    } else {
      ASSERT_EQ(after, any(conditions, AuthorityCondition::kReleaseRequested) ? AuthorityStage::kReleasing
                                                                              : AuthorityStage::kInControl)
          << std::hex << bits;
    }
  }
}

/// In every stage on the way to control, a loss leads to silence, whatever other signs are set.
TEST(AuthorityTable, ALossOnTheWayToControlEndsTheAttempt) {
  for (const AuthorityStage stage :
       {AuthorityStage::kObtaining, AuthorityStage::kSpacing, AuthorityStage::kConfirming, AuthorityStage::kEnabling}) {
    for (std::uint32_t bits = 0; bits < (1U << 22U); ++bits) {  // no row of these stages needs kReleasePending
      const AuthorityCondition conditions = static_cast<AuthorityCondition>(bits);
      const bool lost = !all(conditions, AuthorityCondition::kLinkAlive | AuthorityCondition::kItemsFresh |
                                             AuthorityCondition::kModeF) ||
                        any(conditions, AuthorityCondition::kRestarted | AuthorityCondition::kControlLostPush);
      const AuthorityStage after = next(stage, lost ? conditions : conditions | AuthorityCondition::kOwnStall);
      ASSERT_TRUE(after == AuthorityStage::kSilent || after == AuthorityStage::kSilentCold)
          << name(stage) << " " << std::hex << bits;
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
  std::size_t most = 0;
  for (int i = 0; i < 400000; ++i) {
    // Levels last for a while; edges are rare.
    const auto levels =
        static_cast<AuthorityCondition>((random() | random()) & (i % 50 < 40 ? 0x7CCU : 0x7CCU & random()));
    const auto edges = static_cast<AuthorityCondition>(random() % 8 == 0 ? 1U << (random() % 25U) : 0U);
    const AuthorityStep made = step(state, levels | edges, kTick);
    ASSERT_TRUE(made.moved || (made.state.stage == state.stage && made.state.reason == state.reason));
    state = made.state;
    since_request += kTick;
    if (made.action == AuthorityAction::kReleaseControl) {
      while (!last_second.empty() && (i - last_second.front()) * kTick >= std::chrono::seconds(1)) {
        last_second.pop_front();
      }
      last_second.push_back(i);
      ASSERT_LE(last_second.size(), 5U) << "step " << i;
      most = std::max(most, last_second.size());
    } else if (made.action == AuthorityAction::kRequestControl) {
      ASSERT_GE(since_request, kRequestSpacing) << "step " << i;
      since_request = core::Duration{0};
    }
  }
  EXPECT_EQ(most, 5U);
  const AuthorityCondition withdrawn = AuthorityCondition::kLinkAlive | AuthorityCondition::kItemsFresh |
                                       AuthorityCondition::kModeF | AuthorityCondition::kReleaseRequested;
  EXPECT_EQ(step({.stage = AuthorityStage::kObtaining}, withdrawn, kTick).action, AuthorityAction::kReleaseControl)
      << "a grant may be on its way";
}

TEST(AuthorityTable, EveryReasonAndEveryStageHasAName) {
  for (std::size_t stage = 0; stage < kStageCount; ++stage) {
    EXPECT_FALSE(name(static_cast<AuthorityStage>(stage)).empty());
  }
  for (const AuthorityTransition& row : kAuthorityTable) {
    EXPECT_FALSE(name(row.reason).empty());
    const bool is_end = row.to == AuthorityStage::kSilent || row.to == AuthorityStage::kSilentCold ||
                        row.to == AuthorityStage::kPausing;
    EXPECT_EQ(is_end && remedy(row.reason).empty(), false) << name(row.reason) << " has no remedy for the operator";
  }
}

}  // namespace
}  // namespace m100::safety
