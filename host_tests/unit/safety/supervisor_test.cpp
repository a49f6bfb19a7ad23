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
  Observation good() const {
    return {.now = now_,
            .pose_age = milliseconds(20),
            .telemetry_age = milliseconds(5),
            .estimate_healthy = true,
            .authority = true,
            .mode_f = true};
  }
  Grant<double> tick(Observation seen, const ctl::Command<double>& wanted = kWanted) {
    now_ += milliseconds(10);
    seen.now = now_;
    return supervisor_.review(wanted, {}, seen, 0.01);
  }
  void fly() {
    for (int i = 0; i < 12; ++i) {
      tick(good());
    }
    Observation engage = good();
    engage.operator_engages = true;
    ASSERT_EQ(tick(engage).rung, Rung::kNominal);
    for (int i = 0; i < 20; ++i) {
      tick(good());
    }
  }
  /// Ticks until the state is left. @returns how many; 0: not within five seconds.
  int ticks_in(Rung state, const Observation& seen) {
    for (int i = 1; i <= 500; ++i) {
      if (tick(seen).rung != state) {
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
  Observation old = good();
  old.pose_age = milliseconds(61);
  EXPECT_EQ(tick(old).rung, Rung::kCoast);
  EXPECT_EQ(ticks_in(Rung::kCoast, old), 70);  // 700 ms
  EXPECT_EQ(supervisor_.rung(), Rung::kLevel);
  EXPECT_EQ(tick(old).command.roll_rad, 0.0);  // level
  EXPECT_EQ(ticks_in(Rung::kLevel, old), 99);  // 1 s
  EXPECT_EQ(supervisor_.rung(), Rung::kRelease);
  EXPECT_EQ(ticks_in(Rung::kRelease, old), 50);  // neutral for 0.5 s
  EXPECT_EQ(supervisor_.rung(), Rung::kSilent);
}

// Catches a limit that punishes the honest sender of an old pose, and one that grows without end.
TEST(FreshLimit, FollowsFromTheMeasuredLatency) {
  constexpr Limits kDefault;
  EXPECT_EQ(fresh_limit(kDefault, {}), milliseconds(60));
  EXPECT_EQ(fresh_limit(kDefault, {milliseconds(20), milliseconds(5), milliseconds(10)}), milliseconds(60));
  EXPECT_EQ(fresh_limit(kDefault, {milliseconds(70), milliseconds(5), milliseconds(10)}), milliseconds(100));
  EXPECT_EQ(fresh_limit(kDefault, {milliseconds(100), milliseconds(40), milliseconds(33)}), milliseconds(223));
  EXPECT_EQ(fresh_limit(kDefault, {milliseconds(200), milliseconds(40), milliseconds(33)}), milliseconds(250));
  constexpr Limits kSaid{.pose_fresh = milliseconds(80), .pose_fresh_is_said = true};
  EXPECT_EQ(fresh_limit(kSaid, {milliseconds(100), milliseconds(40), milliseconds(33)}), milliseconds(80));
}

TEST_F(Ladder, FliesOnThePoseOfALongWay) {
  RecordProperty("promise", "R3");
  fly();
  Observation late = good();
  late.pose_age = milliseconds(115);
  late.pose_latency = {.least = milliseconds(100), .jitter = milliseconds(5), .interval = milliseconds(10)};
  EXPECT_EQ(tick(late).rung, Rung::kNominal);
  late.pose_age = milliseconds(131);
  EXPECT_EQ(tick(late).rung, Rung::kCoast);
}

TEST_F(Ladder, GivesControlBackInExactlyOneTick) {
  fly();
  Observation leave = good();
  leave.operator_releases = true;
  int releases = 0;
  for (int i = 0; i < 200; ++i) {
    releases += tick(leave).release ? 1 : 0;
  }
  EXPECT_EQ(releases, 1);
}

TEST_F(Ladder, ComesBackFromCoastAfterTenGoodTicks) {
  fly();
  Observation old = good();
  old.pose_age = milliseconds(61);
  tick(old);
  EXPECT_EQ(ticks_in(Rung::kCoast, good()), 10);
  EXPECT_EQ(supervisor_.rung(), Rung::kNominal);
}

TEST_F(Ladder, StaysLevelUntilTheOperatorComes) {
  fly();
  Observation lost = good();
  lost.refused_for = milliseconds(300);
  EXPECT_EQ(tick(lost).rung, Rung::kLevel);
  for (int i = 0; i < 50; ++i) {
    EXPECT_EQ(tick(good()).rung, Rung::kLevel);
  }
  Observation engage = good();
  engage.operator_engages = true;
  EXPECT_EQ(tick(engage).rung, Rung::kNominal);
}

struct Loss {
  const char* name;
  void (*change)(Observation&);
  Rung expected;
  bool transmits;
};
class LossOf : public Ladder, public ::testing::WithParamInterface<Loss> {};
TEST_P(LossOf, IsAnsweredInTheSameTick) {
  RecordProperty("promise", "R4");
  fly();
  Observation seen = good();
  GetParam().change(seen);
  const Grant<double> grant = tick(seen);
  EXPECT_EQ(grant.rung, GetParam().expected);
  EXPECT_EQ(grant.transmit, GetParam().transmits);
}
INSTANTIATE_TEST_SUITE_P(
    Table, LossOf,
    ::testing::Values(Loss{"Authority", [](Observation& f) { f.authority = false; }, Rung::kSilent, false},
                      Loss{"ModeF", [](Observation& f) { f.mode_f = false; }, Rung::kSilent, false},
                      Loss{"Link", [](Observation& f) { f.telemetry_age = milliseconds(501); }, Rung::kRelease, true},
                      Loss{"LinkBriefly", [](Observation& f) { f.telemetry_age = milliseconds(101); }, Rung::kCoast,
                           true},
                      Loss{"Estimate", [](Observation& f) { f.estimate_healthy = false; }, Rung::kLevel, true},
                      Loss{"PoseAndMode",
                           [](Observation& f) {
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
