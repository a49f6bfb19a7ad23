// SPDX-License-Identifier: BSD-3-Clause
// A sample of the unseen logs; soak.identify_unseen_logs covers all kinds and the shares.
#include "host_tests/property/identify/unseen_log.h"

#include <gtest/gtest.h>

#include <cmath>
#include <ostream>

#include "host_tests/property/identify/unseen_log_bound.h"
#include "host_tests/property/identify/unseen_log_flight.h"

namespace m100::host_tests {
namespace {

struct Case {
  const char* name;
  const char* kind;
  std::uint64_t seed;
};
void PrintTo(const Case& one, std::ostream* out) { *out << one.kind << ", seed " << one.seed; }

class UnseenLogTest : public ::testing::TestWithParam<Case> {};

// Catches "nothing missing" although the log shows a hidden effect, and a healthy log that gets none.
TEST_P(UnseenLogTest, IsAnsweredRight) {
  RecordProperty("promise", "R13");
  const AdversarialLog truth = unseen_log(GetParam().kind, GetParam().seed);
  const lab::identify::IdentifyResult result = identify_log(truth);
  const Classification answer = classify(truth, result);
  EXPECT_TRUE(answer == Classification::kRight || (answer == Classification::kUndecided && !truth.healthy))
      << static_cast<int>(answer) << ", " << result.verdict
      << (result.unexplained.empty() ? "" : ": " + result.unexplained.front());
}

INSTANTIATE_TEST_SUITE_P(
    Table, UnseenLogTest,
    ::testing::Values(
        Case{"Healthy", "healthy, any hand", 1}, Case{"SharpSticks", "healthy, sharp sticks", 4},
        Case{"ClosedLoop", "healthy, closed loop", 4}, Case{"GainChanges", "gain changes 10 to 35 %", 2},
        Case{"Backlash", "lacks: backlash", 12}, Case{"CrossAxis", "lacks: cross axis", 11},
        Case{"PulsesOfAMachine", "healthy, sharp sticks", 103}, Case{"RoundedAtRest", "healthy, any hand", 102},
        Case{"SlowRows", "healthy, closed loop", 102}, Case{"CertainButSmall", "lacks: lead zero", 203},
        Case{"EarlyClock", "clock, net -20 to -60 ms", 12}, Case{"CurveBehindAJump", "lacks: stick curve", 11},
        Case{"HoldsInSlowRows", "healthy, any hand", 7101}, Case{"LoopInSlowRows", "healthy, closed loop", 7102},
        Case{"LateInSlowRows", "healthy, clock 20 to 80 ms late: a delay", 8101},
        Case{"SlowerModeForAWhile", "another mode for a while", 9101},
        Case{"ModeForAWhile", "another mode for a while", 9104},
        Case{"ZeroOrClockInSlowRows", "clock, net -20 to -60 ms", 9103},
        Case{"DelayThatChangesInSlowRows", "delay grows 20 to 80 ms", 9701},
        Case{"GainOnAWrongDate", "gain changes 10 to 35 %", 8101},
        Case{"GainThatLooksLikeDrift", "gain changes 10 to 35 %", 7003}, Case{"Tether", "tether in climb", 7002},
        Case{"DelayHiddenBySlowRows", "delay grows 20 to 80 ms", 16007},
        Case{"DelayThatGrowsInHolds", "delay grows 20 to 80 ms", 18009},
        Case{"DeadZoneThatGrowsInSlowRows", "dead zone grows 10 to 25 counts", 18001},
        Case{"DeadZoneThatGrowsInClimb", "dead zone grows 10 to 25 counts", 16008},
        Case{"DoubletsInSlowRows", "healthy, sharp sticks", 17006},
        Case{"DoubletsOfAnyHand", "healthy, any hand", 17006}, Case{"FreezeThatBendsTheFit", "frozen stick", 51015},
        Case{"FreezeInSlowRows", "frozen stick", 51002}, Case{"TrimStepInClimb", "trim changes 20 to 80 counts", 51010},
        Case{"CertainZeroInAir", "lacks: lead zero", 51001},
        Case{"RowsJustBeforeTheStick", "healthy, sharp sticks", 20261131},
        Case{"ZeroOfOneRow", "healthy, any hand", 20261138}, Case{"FastRows", "healthy, sharp sticks", 20261132},
        Case{"FastRowsOfALoop", "healthy, closed loop", 20261157},
        Case{"BeatOfRowsAndStick", "healthy, any hand", 20261145},
        Case{"StartsInSlowRows", "healthy, any hand", 20261156},
        Case{"LimitOfTwoPositions", "healthy, sharp sticks", 730107},
        Case{"DeadZoneOfTwoPositions", "healthy, sharp sticks", 740081},
        Case{"RateLimitBetweenRows", "healthy, any hand", 740071},
        Case{"ShiftWithinRows", "healthy, sharp sticks", 730139}, Case{"ZeroOfSlowRows", "healthy, any hand", 740039},
        Case{"FewDegrees", "healthy, any hand", 740079},
        Case{"DriftThatLooksLikeAChange", "lacks: gain drift", 770005}),
    [](const auto& one) { return one.param.name; });

// Catches an ablation that runs every log with all tests: without the test of the freeze, none may be reported.
TEST(UnseenLogAblation, LeavesOutTheTestThatIsForbidden) {
  using lab::identify::SpecialTest;
  const AdversarialLog truth = unseen_log("frozen stick", 51002);
  for (const bool may : {true, false}) {
    bool asked = false;
    const lab::identify::IdentifyResult result = identify_log(truth, 0, [&](SpecialTest test) {
      asked = asked || test == SpecialTest::kFrozenStick;
      return may || test != SpecialTest::kFrozenStick;
    });
    EXPECT_TRUE(asked);
    EXPECT_EQ(classify(truth, result) == Classification::kRight, may) << result.verdict;
  }
}

// Catches a judge that excuses false acceptances: a large hidden effect must count as visible, an absent one not.
TEST(UnseenLogBound, TellsWhatALogCanShow) {
  UnseenLogRandom rng(5);
  UnseenLogFlight flight;
  flight.before.delay_s = 0.03;
  flight.noise = {.air = 0.004, .air_s = 0.4, .white = 0.001, .row_s = 0.01};
  const std::vector<std::string> declared{"second_order", "transport_delay"};
  const auto bound = [&](const UnseenLogParameters& flown) {
    UnseenLogFlight other = flight;
    other.before = flown;
    const UnseenLogRecord record = fly(other, rng);
    return evidence_of(record.clean, record.steps, record.sticks, flight.before, declared, flight.noise);
  };
  EXPECT_LT(bound(flight.before), 1.0);
  UnseenLogParameters dead = flight.before;
  dead.dead_zone_counts = 30.0;
  EXPECT_GT(bound(dead), kUnseenLogVisible);
  UnseenLogParameters hardly = flight.before;
  hardly.dead_zone_counts = 1.0;
  EXPECT_LT(bound(hardly), kUnseenLogVisible);
  UnseenLogParameters other_gain = flight.before;  // another value of a declared parameter is no hidden effect
  other_gain.gain *= 1.3;
  EXPECT_LT(bound(other_gain), 1.0);
}

// Catches a judge that blames "nothing missing" on a shift that the same rows have without it.
TEST(UnseenLogBound, CountsNoShiftWithinASampleOfTheStick) {
  UnseenLogRandom rng(6);
  UnseenLogFlight flight;
  flight.hand = UnseenLogInput::kHolds;
  flight.noise = {.air = 0.002, .air_s = 0.4, .white = 0.001, .row_s = 0.02};
  flight.response_early_s = 0.01;
  const UnseenLogRecord record = fly(flight, rng);
  const auto bound = [&](const UnseenLogSticks& sticks) {
    return evidence_of(record.clean, record.steps, sticks, flight.before, {"second_order", "transport_delay"},
                       flight.noise);
  };
  EXPECT_GT(bound(record.sticks), kUnseenLogVisible);
  EXPECT_LT(bound(record.sticks_read_late(0.01, 1e9)), kUnseenLogVisible);
}

// Catches a change of gain or trim that is named although the vehicle has landed and the pilot holds the stick.
TEST(UnseenLogLanding, WithAHeldStickIsNoChangeOfTheVehicle) {
  UnseenLogRandom rng(1);
  UnseenLogFlight flight;
  flight.before.delay_s = 0.03;
  flight.noise = {.air = 0.004, .air_s = 0.4, .white = 2e-4, .row_s = 0.02};
  flight.rest_from_s = 47.0;
  UnseenLogRecord record = fly(flight, rng);
  for (std::size_t k = 0; k < record.rows.time_s.size(); ++k) {
    record.rows.own[k] = record.rows.time_s[k] > flight.rest_from_s - 0.5 ? 90.0 : record.rows.own[k];
  }
  AdversarialLog landed;
  landed.log = record.rows.log();
  landed.train = {{2.0, 40.0}};
  landed.validate = {{40.0, 59.0}};
  const lab::identify::IdentifyResult result = identify_log(landed);
  EXPECT_EQ(result.verdict, "unexplained");
  EXPECT_TRUE(result.changes.empty()) << result.changes.front().name;
}

}  // namespace
}  // namespace m100::host_tests
