// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/safety/supervisor.h"

#include <gtest/gtest.h>
#include <cmath>
#include <limits>
#include <utility>

namespace m100::safety {
namespace {

using std::chrono::milliseconds;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr ctl::Command<double> kLaw{.roll_rad = 0.1, .pitch_rad = -0.05, .climb_m_s = 0.3, .yaw_rate_rad_s = 0.2};

/// A supervisor and its observations, with ticks of 10 ms.
class FailsafeStates : public ::testing::Test {
 protected:
  Observation good() const {
    return {.now = now_,
            .estimate = {.pose_age = milliseconds(20), .healthy = true},
            .link = {.telemetry_age = milliseconds(5), .in_control = true, .mode_f = true}};
  }
  SupervisedCommand<double> tick(Observation seen, const ctl::Command<double>& wanted = kLaw) {
    now_ += milliseconds(10);
    seen.now = now_;
    return supervisor_.review(wanted, {}, seen, 0.01);
  }
  void fly() {
    for (int i = 0; i < 12; ++i) {
      tick(good());
    }
    Observation engage = good();
    engage.orders.engages = true;
    ASSERT_EQ(tick(engage).failsafe_state, FailsafeState::kNominal);
    for (int i = 0; i < 20; ++i) {
      tick(good());
    }
  }
  /// Runs ticks until the state is left. @returns their number; 0: not within five seconds.
  int ticks_in(FailsafeState state, const Observation& seen) {
    for (int i = 1; i <= 500; ++i) {
      if (tick(seen).failsafe_state != state) {
        return i;
      }
    }
    return 0;
  }

  core::TimePoint now_{};
  Supervisor<double> supervisor_{Limits{}, Envelope{}};
};

// Catches a freshness limit that punishes a sender which reports the true age of its poses, and one that grows without
// bound.
TEST(FreshLimit, FollowsFromTheMeasuredLatency) {
  constexpr Limits kDefault;
  EXPECT_EQ(fresh_limit(kDefault, {}), milliseconds(60));
  EXPECT_EQ(fresh_limit(kDefault, {milliseconds(20), milliseconds(5), milliseconds(10)}), milliseconds(60));
  EXPECT_EQ(fresh_limit(kDefault, {milliseconds(70), milliseconds(5), milliseconds(10)}), milliseconds(100));
  EXPECT_EQ(fresh_limit(kDefault, {milliseconds(100), milliseconds(40), milliseconds(33)}), milliseconds(223));
  EXPECT_EQ(fresh_limit(kDefault, {milliseconds(200), milliseconds(40), milliseconds(33)}), milliseconds(250));
  constexpr Limits kSaid{.pose_fresh = milliseconds(80), .pose_fresh_is_set = true};
  EXPECT_EQ(fresh_limit(kSaid, {milliseconds(100), milliseconds(40), milliseconds(33)}), milliseconds(80));
}

TEST_F(FailsafeStates, FliesOnThePoseOfALongWay) {
  RecordProperty("promise", "R3");
  fly();
  Observation late = good();
  late.estimate.pose_age = milliseconds(115);
  late.pose_latency = {.min_latency = milliseconds(100), .jitter = milliseconds(5), .interval = milliseconds(10)};
  EXPECT_EQ(tick(late).failsafe_state, FailsafeState::kNominal);
  late.estimate.pose_age = milliseconds(131);
  EXPECT_EQ(tick(late).failsafe_state, FailsafeState::kCoast);
}

TEST_F(FailsafeStates, GivesControlBackInExactlyOneTick) {
  fly();
  Observation leave = good();
  leave.orders.releases = true;
  int releases = 0;
  for (int i = 0; i < 200; ++i) {
    releases += tick(leave).release ? 1 : 0;
  }
  EXPECT_EQ(releases, 1);
}

// Catches a count of ten ticks instead of ten poses: at 30 Hz three poses were enough.
TEST_F(FailsafeStates, ComesBackFromCoastAfterTenGoodPosesHoweverSlowTheyCome) {
  RecordProperty("promise", "R3");
  fly();
  Observation old = good();
  old.estimate.pose_age = milliseconds(61);
  tick(old);
  int poses = 0;
  for (int i = 0; supervisor_.failsafe_state() == FailsafeState::kCoast; ++i) {
    Observation seen = good();
    seen.estimate.pose_age = milliseconds(20 + 10 * (i % 4));  // a new one every fourth tick
    poses += i % 4 == 0 ? 1 : 0;
    tick(seen);
    ASSERT_LE(i, 100);
  }
  EXPECT_EQ(poses, 10);
  EXPECT_EQ(supervisor_.failsafe_state(), FailsafeState::kNominal);
}

// Catches an order that cannot be carried out and that delays the handover to the pilot for as long as it stands (20
// s).
TEST_F(FailsafeStates, HandsOverThoughAnOrderStands) {
  RecordProperty("promise", "R15");
  fly();
  Observation lost = good();
  lost.estimate.pose_age = milliseconds(800);
  tick(lost);
  ASSERT_EQ(ticks_in(FailsafeState::kCoast, lost), 70);
  lost.orders.engages = true;
  EXPECT_EQ(ticks_in(FailsafeState::kLevel, lost), 100);
  EXPECT_EQ(supervisor_.failsafe_state(), FailsafeState::kRelease);
}

// Catches a release with half a second of level sticks, in a wind that the aircraft was just held against.
TEST_F(FailsafeStates, HoldsAgainstTheWindUntilTheSticksAreThePilots) {
  fly();
  Observation lost = good();
  lost.wind.exceeded_for = milliseconds(3000);
  EXPECT_EQ(tick(lost).failsafe_state, FailsafeState::kLevel);
  EXPECT_EQ(supervisor_.descent().reason, FailsafeReason::kAuthorityExceeded);
  const ctl::Command<double> held{.roll_rad = 0.1, .pitch_rad = -0.4};
  for (int i = 0; i < 140; ++i) {
    now_ += milliseconds(10);
    Observation seen = good();
    seen.now = now_;
    const SupervisedCommand<double> grant = supervisor_.review(kLaw, held, seen, 0.01);
    ASSERT_EQ(grant.failsafe_state, i < 99 ? FailsafeState::kLevel : FailsafeState::kRelease) << i;
    if (i > 3) {
      ASSERT_EQ(grant.command.pitch_rad, held.pitch_rad) << i;
    }
  }
  // When the operator gives control back, the sticks are level.
  supervisor_ = Supervisor<double>{Limits{}, Envelope{}};
  fly();
  Observation leave = good();
  leave.orders.releases = true;
  EXPECT_EQ(tick(leave).failsafe_state, FailsafeState::kRelease);
  EXPECT_EQ(tick(good()).command.pitch_rad, 0.0);
}

struct Loss {
  const char* name;
  void (*change)(Observation&);
  FailsafeState expected;
  bool transmits;
};
class LossOf : public FailsafeStates, public ::testing::WithParamInterface<Loss> {};
TEST_P(LossOf, IsAnsweredInTheSameTick) {
  RecordProperty("promise", "R4");
  fly();
  Observation seen = good();
  GetParam().change(seen);
  const SupervisedCommand<double> grant = tick(seen);
  EXPECT_EQ(grant.failsafe_state, GetParam().expected);
  EXPECT_EQ(grant.transmit, GetParam().transmits);
}
INSTANTIATE_TEST_SUITE_P(
    Table, LossOf,
    ::testing::Values(
        Loss{"Authority", [](Observation& f) { f.link.in_control = false; }, FailsafeState::kSilent, false},
        Loss{"ModeF", [](Observation& f) { f.link.mode_f = false; }, FailsafeState::kSilent, false},
        Loss{"Link", [](Observation& f) { f.link.telemetry_age = milliseconds(501); }, FailsafeState::kRelease, true},
        Loss{"Estimate", [](Observation& f) { f.estimate.healthy = false; }, FailsafeState::kLevel, true},
        Loss{"PoseAndMode",
             [](Observation& f) {
               f.estimate.pose_age = milliseconds(500);
               f.link.mode_f = false;
             },
             FailsafeState::kSilent, false}),
    [](const auto& tested) { return tested.param.name; });

class Unsound : public FailsafeStates, public ::testing::WithParamInterface<double> {};
TEST_P(Unsound, CommandBecomesNeutralAndLevel) {
  RecordProperty("promise", "R5");
  fly();
  ctl::Command<double> wanted = kLaw;
  wanted.pitch_rad = GetParam();
  const SupervisedCommand<double> grant = tick(good(), wanted);
  EXPECT_EQ(grant.failsafe_state, FailsafeState::kLevel);
  EXPECT_EQ(grant.command.pitch_rad, 0.0);
  EXPECT_EQ(supervisor_.stats().invalid_commands, 1U);
}
INSTANTIATE_TEST_SUITE_P(Values, Unsound,
                         ::testing::Values(kNan, std::numeric_limits<double>::infinity(), -1e300, 3.0));

TEST_F(FailsafeStates, SlewsInsteadOfJumping) {
  RecordProperty("promise", "R5");
  fly();
  ctl::Command<double> wanted = kLaw;
  wanted.roll_rad = 0.43;
  EXPECT_NEAR(tick(good(), wanted).command.roll_rad, 0.1 + 20.0 * 0.01, 1e-12);
  EXPECT_NEAR(tick(good(), wanted).command.roll_rad, 0.43, 1e-12);
  EXPECT_NEAR(tick(good(), {.roll_rad = 0.6}).command.roll_rad, 0.5235987755982988, 1e-12);
}

// Catches a limit of 30 degrees for each axis alone: together they tilt by 41 degrees, and R12 allows 35.
TEST_F(FailsafeStates, LeansByNoMoreThanItsLimitWhateverTheDirection) {
  RecordProperty("promise", "R12");
  fly();
  for (const auto& [roll_rad, pitch_rad] : {std::pair(0.52, 0.52), std::pair(-0.6, 0.3), std::pair(0.2, -1.0)}) {
    const ctl::Command<double> wanted{.roll_rad = roll_rad, .pitch_rad = pitch_rad};
    ctl::Command<double> granted;
    for (int i = 0; i < 20; ++i) {
      granted = tick(good(), wanted).command;
      EXPECT_LE(std::acos(std::cos(granted.roll_rad) * std::cos(granted.pitch_rad)), 0.5236 + 1e-4);
    }
    EXPECT_NEAR(std::hypot(granted.pitch_rad, granted.roll_rad), 0.5235987755982988, 1e-12);
    EXPECT_NEAR(granted.pitch_rad / granted.roll_rad, pitch_rad / roll_rad, 1e-9) << "the direction is kept";
  }
  const ctl::Command<double> right{.roll_rad = 0.3, .pitch_rad = 0.4};
  for (int i = 0; i < 20; ++i) {
    tick(good(), right);
  }
  const std::uint32_t limited = supervisor_.stats().limited_commands;
  EXPECT_EQ(tick(good(), right).command.pitch_rad, 0.4) << "what is inside is left alone";
  EXPECT_EQ(supervisor_.stats().limited_commands, limited);
  tick(good(), {.roll_rad = 0.36, .pitch_rad = 0.48});
  EXPECT_EQ(supervisor_.stats().limited_commands, limited + 1);
}

TEST(FailsafeCondition, EachHasItsOwnBitOfTheLog) {
  using enum FailsafeCondition;
  std::uint32_t bit = 1;
  for (const FailsafeCondition condition : {kCommandable,        kOperatorReleases,
                                            kTelemetryDead,      kCommandInvalid,
                                            kEstimateLost,       kFresh,
                                            kRecovered,          kCoastOver,
                                            kLevelOver,          kNeutralOver,
                                            kOperatorEngages,    kRollModelMismatch,
                                            kPitchModelMismatch, kYawRateModelMismatch,
                                            kClimbModelMismatch, kTrimDrifted,
                                            kReserveSpent,       kOutsideFence,
                                            kAuthorityExceeded,  kTaskFlies,
                                            kLimitCycle,         kLimitCyclePersists,
                                            kOnGround,           kFlightFailure}) {
    EXPECT_EQ(static_cast<std::uint32_t>(condition), bit);
    bit <<= 1;
  }
}

}  // namespace
}  // namespace m100::safety
