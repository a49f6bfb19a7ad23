// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/safety/supervisor.h"

#include <gtest/gtest.h>
#include <cmath>
#include <limits>

namespace m100::safety {
namespace {

using std::chrono::milliseconds;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr ctl::Command<double> kWanted{.roll_rad = 0.1, .pitch_rad = -0.05, .climb_m_s = 0.3, .yaw_rate_rad_s = 0.2};

/// A supervisor and the world it hears of, ten milliseconds a tick.
class Ladder : public ::testing::Test {
 protected:
  Facts good() const {
    return {.now = now_,
            .pose_age = milliseconds(20),
            .telemetry_age = milliseconds(5),
            .estimate_healthy = true,
            .authority = true,
            .mode_f = true};
  }
  Grant<double> tick(Facts facts, const ctl::Command<double>& wanted = kWanted) {
    now_ += milliseconds(10);
    facts.now = now_;
    return supervisor_.review(wanted, facts, 0.01);
  }
  void fly() {
    for (int i = 0; i < 12; ++i) {
      tick(good());
    }
    Facts engage = good();
    engage.operator_engages = true;
    ASSERT_EQ(tick(engage).rung, Rung::kNominal);
    for (int i = 0; i < 20; ++i) {
      tick(good());
    }
  }
  /// Ticks until the state is left. @returns how many; 0: not within five seconds.
  int ticks_in(Rung state, const Facts& facts) {
    for (int i = 1; i <= 500; ++i) {
      if (tick(facts).rung != state) {
        return i;
      }
    }
    return 0;
  }

  core::TimePoint now_{};
  Supervisor<double> supervisor_{Limits{}, Envelope{}};
};

TEST_F(Ladder, SendsNothingUntilAPersonAsks) {
  for (int i = 0; i < 100; ++i) {
    EXPECT_FALSE(tick(good()).transmit);
  }
}

TEST_F(Ladder, PassesTheLawOnceItFlies) {
  fly();
  const Grant<double> grant = tick(good());
  EXPECT_TRUE(grant.transmit);
  EXPECT_EQ(grant.command.roll_rad, kWanted.roll_rad);
  EXPECT_EQ(grant.command.climb_m_s, kWanted.climb_m_s);
}

TEST_F(Ladder, WalksDownWhenThePoseStaysAway) {
  RecordProperty("promise", "R3");
  fly();
  Facts old = good();
  old.pose_age = milliseconds(61);
  EXPECT_EQ(tick(old).rung, Rung::kCoast);
  EXPECT_EQ(ticks_in(Rung::kCoast, old), 20);  // 200 ms
  EXPECT_EQ(supervisor_.rung(), Rung::kLevel);
  EXPECT_EQ(tick(old).command.roll_rad, 0.0);  // level
  EXPECT_EQ(ticks_in(Rung::kLevel, old), 99);  // 1 s
  EXPECT_EQ(supervisor_.rung(), Rung::kRelease);
  EXPECT_EQ(ticks_in(Rung::kRelease, old), 50);  // neutral for 0.5 s
  EXPECT_EQ(supervisor_.rung(), Rung::kSilent);
}

TEST_F(Ladder, GivesControlBackInExactlyOneTick) {
  fly();
  Facts leave = good();
  leave.operator_releases = true;
  int releases = 0;
  for (int i = 0; i < 200; ++i) {
    releases += tick(leave).release ? 1 : 0;
  }
  EXPECT_EQ(releases, 1);
}

TEST_F(Ladder, ComesBackFromCoastAfterTenGoodTicks) {
  fly();
  Facts old = good();
  old.pose_age = milliseconds(61);
  tick(old);
  EXPECT_EQ(ticks_in(Rung::kCoast, good()), 10);
  EXPECT_EQ(supervisor_.rung(), Rung::kNominal);
}

TEST_F(Ladder, StaysLevelUntilTheOperatorComes) {
  fly();
  Facts lost = good();
  lost.refused_poses = 5;
  EXPECT_EQ(tick(lost).rung, Rung::kLevel);
  for (int i = 0; i < 50; ++i) {
    EXPECT_EQ(tick(good()).rung, Rung::kLevel);
  }
  Facts engage = good();
  engage.operator_engages = true;
  EXPECT_EQ(tick(engage).rung, Rung::kNominal);
}

struct Loss {
  const char* name;
  void (*change)(Facts&);
  Rung expected;
  bool transmits;
};
class LossOf : public Ladder, public ::testing::WithParamInterface<Loss> {};
TEST_P(LossOf, IsAnsweredInTheSameTick) {
  RecordProperty("promise", "R4");
  fly();
  Facts facts = good();
  GetParam().change(facts);
  const Grant<double> grant = tick(facts);
  EXPECT_EQ(grant.rung, GetParam().expected);
  EXPECT_EQ(grant.transmit, GetParam().transmits);
}
INSTANTIATE_TEST_SUITE_P(
    Table, LossOf,
    ::testing::Values(Loss{"Authority", [](Facts& f) { f.authority = false; }, Rung::kSilent, false},
                      Loss{"ModeF", [](Facts& f) { f.mode_f = false; }, Rung::kSilent, false},
                      Loss{"Link", [](Facts& f) { f.telemetry_age = milliseconds(501); }, Rung::kRelease, true},
                      Loss{"LinkBriefly", [](Facts& f) { f.telemetry_age = milliseconds(101); }, Rung::kCoast, true},
                      Loss{"Estimate", [](Facts& f) { f.estimate_healthy = false; }, Rung::kLevel, true},
                      Loss{"PoseAndMode",
                           [](Facts& f) {
                             f.pose_age = milliseconds(500);
                             f.mode_f = false;
                           },
                           Rung::kSilent, false}),
    [](const auto& tested) { return tested.param.name; });

class Unsound : public Ladder, public ::testing::WithParamInterface<double> {};
TEST_P(Unsound, CommandBecomesNeutralAndLevel) {
  RecordProperty("promise", "R5");
  fly();
  ctl::Command<double> wanted = kWanted;
  wanted.pitch_rad = GetParam();
  const Grant<double> grant = tick(good(), wanted);
  EXPECT_EQ(grant.rung, Rung::kLevel);
  EXPECT_EQ(grant.command.pitch_rad, 0.0);
  EXPECT_EQ(supervisor_.stats().unsound_commands, 1U);
}
INSTANTIATE_TEST_SUITE_P(Values, Unsound,
                         ::testing::Values(kNan, std::numeric_limits<double>::infinity(), -1e300, 3.0));

TEST_F(Ladder, SlewsInsteadOfJumping) {
  RecordProperty("promise", "R5");
  fly();
  ctl::Command<double> wanted = kWanted;
  wanted.roll_rad = 0.43;
  EXPECT_NEAR(tick(good(), wanted).command.roll_rad, 0.1 + 20.0 * 0.01, 1e-12);
  EXPECT_NEAR(tick(good(), wanted).command.roll_rad, 0.43, 1e-12);
  EXPECT_NEAR(tick(good(), {.roll_rad = 0.6}).command.roll_rad, 0.4363323129985824, 1e-12);
}

}  // namespace
}  // namespace m100::safety
