// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/safety/supervisor.h"

#include <cmath>
#include <limits>
#include <utility>

#include "host_tests/unit/safety/supervised_flight.h"

namespace m100::safety {
namespace {

using std::chrono::milliseconds;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr ctl::Command<double> kLaw{.roll_rad = 0.1, .pitch_rad = -0.05, .climb_m_s = 0.3, .yaw_rate_rad_s = 0.2};

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

TEST(FailsafeStates, FliesOnThePoseOfALongWay) {
  RecordProperty("promise", "R3");
  SupervisedFlight flight(kLaw);
  Observation late = good({});
  late.estimate.pose_age = milliseconds(115);
  late.pose_latency = {.min_latency = milliseconds(100), .jitter = milliseconds(5), .interval = milliseconds(10)};
  EXPECT_EQ(flight.tick(late).failsafe_state, FailsafeState::kNominal);
  late.estimate.pose_age = milliseconds(131);
  EXPECT_EQ(flight.tick(late).failsafe_state, FailsafeState::kCoast);
}

TEST(FailsafeStates, GivesControlBackInExactlyOneTick) {
  SupervisedFlight flight(kLaw);
  Observation leave = good({});
  leave.orders.releases = true;
  int releases = 0;
  for (int i = 0; i < 200; ++i) {
    releases += flight.tick(leave).release ? 1 : 0;
  }
  EXPECT_EQ(releases, 1);
}

// Catches a count of ten ticks instead of ten poses: at 30 Hz three poses were enough.
TEST(FailsafeStates, ComesBackFromCoastAfterTenGoodPosesHoweverSlowTheyCome) {
  RecordProperty("promise", "R3");
  SupervisedFlight flight(kLaw);
  Observation old = good({});
  old.estimate.pose_age = milliseconds(61);
  flight.tick(old);
  int poses = 0;
  for (int i = 0; flight.supervisor.failsafe_state() == FailsafeState::kCoast; ++i) {
    Observation seen = good({});
    seen.estimate.pose_age = milliseconds(20 + 10 * (i % 4));  // a new one every fourth tick
    poses += i % 4 == 0 ? 1 : 0;
    flight.tick(seen);
    ASSERT_LE(i, 100);
  }
  EXPECT_EQ(poses, 10);
  EXPECT_EQ(flight.supervisor.failsafe_state(), FailsafeState::kNominal);
}

// Catches an order that cannot be carried out and that delays the handover to the pilot for as long as it stands (20
// s).
TEST(FailsafeStates, HandsOverThoughAnOrderStands) {
  RecordProperty("promise", "R15");
  SupervisedFlight flight(kLaw);
  Observation lost = good({});
  lost.estimate.pose_age = milliseconds(800);
  flight.tick(lost);
  const auto ticks_in = [&](FailsafeState state) {
    int ticks = 1;
    for (; flight.tick(lost).failsafe_state == state && ticks < 500; ++ticks) {
    }
    return ticks;
  };
  ASSERT_EQ(ticks_in(FailsafeState::kCoast), 70);
  lost.orders.engages = true;
  EXPECT_EQ(ticks_in(FailsafeState::kLevel), 100);
  EXPECT_EQ(flight.supervisor.failsafe_state(), FailsafeState::kRelease);
}

// Catches a release with half a second of level sticks, in a wind that the aircraft was just held against.
TEST(FailsafeStates, HoldsAgainstTheWindUntilTheSticksAreThePilots) {
  SupervisedFlight flight(kLaw);
  Observation lost = good({});
  lost.wind.exceeded_for = milliseconds(3000);
  EXPECT_EQ(flight.tick(lost).failsafe_state, FailsafeState::kLevel);
  EXPECT_EQ(flight.supervisor.descent().reason, FailsafeReason::kAuthorityExceeded);
  const ctl::Command<double> held{.roll_rad = 0.1, .pitch_rad = -0.4};
  for (int i = 0; i < 140; ++i) {
    const SupervisedCommand<double> grant = flight.tick(good({}), kLaw, held);
    ASSERT_EQ(grant.failsafe_state, i < 99 ? FailsafeState::kLevel : FailsafeState::kRelease) << i;
    if (i > 3) {
      ASSERT_EQ(grant.command.pitch_rad, held.pitch_rad) << i;
    }
  }
  // When the operator gives control back, the sticks are level.
  SupervisedFlight other(kLaw);
  Observation leave = good({});
  leave.orders.releases = true;
  EXPECT_EQ(other.tick(leave).failsafe_state, FailsafeState::kRelease);
  EXPECT_EQ(other.tick(good({})).command.pitch_rad, 0.0);
}

struct Loss {
  const char* name;
  void (*change)(Observation&);
  FailsafeState expected;
  bool transmits;
};
class LossOf : public ::testing::TestWithParam<Loss> {};
TEST_P(LossOf, IsAnsweredInTheSameTick) {
  RecordProperty("promise", "R4");
  SupervisedFlight flight(kLaw);
  Observation seen = good({});
  GetParam().change(seen);
  const SupervisedCommand<double> grant = flight.tick(seen);
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

class Unsound : public ::testing::TestWithParam<double> {};
TEST_P(Unsound, CommandBecomesNeutralAndLevel) {
  RecordProperty("promise", "R5");
  SupervisedFlight flight(kLaw);
  ctl::Command<double> wanted = kLaw;
  wanted.pitch_rad = GetParam();
  const SupervisedCommand<double> grant = flight.tick(good({}), wanted);
  EXPECT_EQ(grant.failsafe_state, FailsafeState::kLevel);
  EXPECT_EQ(grant.command.pitch_rad, 0.0);
  EXPECT_EQ(flight.supervisor.stats().invalid_commands, 1U);
}
INSTANTIATE_TEST_SUITE_P(Values, Unsound,
                         ::testing::Values(kNan, std::numeric_limits<double>::infinity(), -1e300, 3.0));

// Catches a limit of 30 degrees for each axis alone: together they tilt by 41 degrees, and R12 allows 35.
TEST(FailsafeStates, LeansByNoMoreThanItsLimitWhateverTheDirection) {
  RecordProperty("promise", "R12");
  SupervisedFlight flight(kLaw);
  for (const auto& [roll_rad, pitch_rad] : {std::pair(0.52, 0.52), std::pair(-0.6, 0.3), std::pair(0.2, -1.0)}) {
    const ctl::Command<double> wanted{.roll_rad = roll_rad, .pitch_rad = pitch_rad};
    ctl::Command<double> granted;
    for (int i = 0; i < 20; ++i) {
      granted = flight.tick(good({}), wanted).command;
      EXPECT_LE(std::acos(std::cos(granted.roll_rad) * std::cos(granted.pitch_rad)), 0.5236 + 1e-4);
    }
    EXPECT_NEAR(std::hypot(granted.pitch_rad, granted.roll_rad), 0.5235987755982988, 1e-12);
    EXPECT_NEAR(granted.pitch_rad / granted.roll_rad, pitch_rad / roll_rad, 1e-9) << "the direction is kept";
  }
  const ctl::Command<double> right{.roll_rad = 0.3, .pitch_rad = 0.4};
  for (int i = 0; i < 20; ++i) {
    flight.tick(good({}), right);
  }
  const std::uint32_t limited = flight.supervisor.stats().limited_commands;
  EXPECT_EQ(flight.tick(good({}), right).command.pitch_rad, 0.4) << "what is inside is left alone";
  EXPECT_EQ(flight.supervisor.stats().limited_commands, limited);
  flight.tick(good({}), {.roll_rad = 0.36, .pitch_rad = 0.48});
  EXPECT_EQ(flight.supervisor.stats().limited_commands, limited + 1);
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
