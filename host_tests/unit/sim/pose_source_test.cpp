// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/world/pose_source.h"

#include <gtest/gtest.h>
#include <cmath>
#include <vector>

namespace m100::sim {
namespace {

using std::chrono::milliseconds;

struct Arrival {
  core::TimePoint at;
  PoseSample pose;
};
constexpr double kSpeed_m_s = 1.0;

/// Records the poses of a vehicle that moves at 1 m/s in x; the source is polled at each of its events.
std::vector<Arrival> record(PoseSource& source, double seconds) {
  std::vector<Arrival> out;
  VehicleState truth;
  truth.velocity_w_m_s.x() = kSpeed_m_s;
  for (core::TimePoint now{}; core::seconds<double>(now.time_since_epoch()) < seconds; now = source.next_event()) {
    truth.position_w_m.x() = kSpeed_m_s * core::seconds<double>(now.time_since_epoch());
    while (const auto sample = source.step(now, truth, 0.5, now)) {
      out.push_back({now, *sample});
    }
  }
  return out;
}

std::vector<Arrival> record(const PoseNumbers& numbers, double seconds, std::uint64_t seed = 1) {
  PoseSource source(numbers, seed);
  return record(source, seconds);
}

double age_s(const Arrival& arrival) { return core::seconds<double>(arrival.at - arrival.pose.captured); }

TEST(PoseSource, DeliversAHundredPosesASecondTwentyMillisecondsOld) {
  const auto poses = record(PoseNumbers{.phase = PosePhase::kLocked}, 1.0);
  EXPECT_EQ(poses.size(), 98U);
  for (const auto& [arrival, pose] : poses) {
    EXPECT_EQ(arrival - pose.captured, milliseconds(20));
    EXPECT_EQ((pose.stamp - poses[0].pose.stamp).count(), (pose.captured - poses[0].pose.captured).count());
    EXPECT_NEAR(pose.position_w_m.x(), core::seconds<double>(pose.captured.time_since_epoch()), 0.006);  // 6 sigma
  }
}

// A source that captures in step with our ticks hides every error of timing, so the phase must differ from seed to
// seed.
TEST(PoseSource, TakesAPhaseOfItsOwnUnlessItIsLocked) {
  const auto first_s = [](PosePhase phase, std::uint64_t seed) {
    return core::seconds<double>(
        record(PoseNumbers{.phase = phase}, 0.1, seed).front().pose.captured.time_since_epoch());
  };
  EXPECT_EQ(first_s(PosePhase::kLocked, 1), first_s(PosePhase::kLocked, 2));
  double sum_s = 0.0;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    const double phase_s = first_s(PosePhase::kRandom, seed);
    EXPECT_GE(phase_s, 0.0);
    EXPECT_LE(phase_s, 0.010);
    sum_s += phase_s / 400.0;
  }
  EXPECT_NEAR(sum_s, 0.005, 4.0 * 0.010 / std::sqrt(12.0 * 400.0));  // four sigmas of the mean of a uniform number
}

TEST(PoseSource, RunsOnItsOwnClock) {
  constexpr double kSeconds = 100.0;
  const auto poses = record({.rate_hz = 240.0, .clock_drift_ppm = 1000.0}, kSeconds);
  EXPECT_NEAR(static_cast<double>(poses.size()), 240.0 * 1.001 * (kSeconds - 0.02), 2.0);
  EXPECT_NEAR(core::seconds<double>(poses[24000].pose.captured - poses[0].pose.captured), 100.0 / 1.001, 2e-6);
}

TEST(PoseSource, LetsPosesOvertakeEachOtherWhereJitterExceedsTheirSpacing) {
  const auto poses = record({.latency_s = 0.05, .jitter_s = 0.04}, 100.0);
  int overtaken = 0;
  double sum_s = 0.0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    EXPECT_GE(age_s(poses[i]), 0.05);
    EXPECT_LE(age_s(poses[i]), 0.09);
    sum_s += age_s(poses[i]) / static_cast<double>(poses.size());
    overtaken += i > 0 && poses[i].pose.sequence < poses[i - 1].pose.sequence ? 1 : 0;
  }
  EXPECT_NEAR(sum_s, 0.07, 4.0 * 0.04 / std::sqrt(12.0 * 1e4));
  EXPECT_GT(overtaken, 1000);  // of ten thousand: a neighbour passes with probability 9/32
}

TEST(PoseSource, BunchesPosesAndLosesNone) {
  const auto poses = record({.burst_s = 0.08, .burst_per_s = 1.0}, 100.0);
  int bunches = 0;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    EXPECT_EQ(poses[i].pose.sequence, poses[i - 1].pose.sequence + 1);
    EXPECT_LE(age_s(poses[i]), 0.1001);
    bunches += core::seconds<double>(poses[i].at - poses[i - 1].at) > 0.075 ? 1 : 0;
  }
  EXPECT_NEAR(bunches, 100.0 / 1.08, 30.0);  // three sigmas
}

// The age computed by a receiver that knows the source's clock: the truth, or off by a constant.
TEST(PoseSource, StampsAsConfigured) {
  const auto reported_ms = [](const PoseNumbers& numbers) {
    PoseSource source(numbers, 1);
    std::vector<double> ages;
    for (const Arrival& arrival : record(source, 1.0)) {
      const double reported_s = std::chrono::duration<double>(source.own_time(arrival.at) - arrival.pose.stamp).count();
      ages.push_back(1e3 * (reported_s - age_s(arrival)));  // beyond the truth
    }
    return ages;
  };
  for (const double beyond_ms : reported_ms({.jitter_s = 0.02})) {
    EXPECT_NEAR(beyond_ms, 0.0, 0.002);
  }
  for (const double beyond_ms : reported_ms({.clock_drift_ppm = 1000.0})) {
    EXPECT_NEAR(beyond_ms, 0.02, 0.002) << "an age of 20 ms on a clock that is fast by 0.1 %";
  }
  for (const double beyond_ms : reported_ms(
           {.latency_s = 0.1, .jitter_s = 0.02, .reported_age = ReportedAge::kConstant, .reported_age_s = 0.03})) {
    EXPECT_NEAR(beyond_ms, -70.0, 0.002);
  }
  EXPECT_TRUE(PoseSource({}, 1).tells_time());
  EXPECT_FALSE(PoseSource({.reported_age = ReportedAge::kNone}, 1).tells_time());
}

TEST(PoseSource, RoundsToItsQuantum) {
  for (const Arrival& arrival : record({.quantum_m = 0.005}, 1.0)) {
    const double steps = arrival.pose.position_w_m.x() / 0.005;
    EXPECT_NEAR(steps, std::round(steps), 1e-9);
  }
}

TEST(PoseSource, IsTheSameHoweverOftenItIsVisited) {
  const PoseNumbers numbers{.jitter_s = 0.03, .burst_s = 0.05, .burst_per_s = 2.0, .phase = PosePhase::kRandom};
  const auto expected = record(numbers, 10.0);
  PoseSource often(numbers, 1);
  std::size_t count = 0;
  for (int i = 0; i < 100000; ++i) {
    const core::TimePoint now(std::chrono::microseconds(100 * i));
    while (const auto sample = often.step(now, VehicleState{}, 0.5, now)) {
      ASSERT_LT(count, expected.size());
      EXPECT_EQ(sample->sequence, expected[count].pose.sequence);
      EXPECT_EQ(sample->captured, expected[count].pose.captured);
      ++count;
    }
  }
  EXPECT_NEAR(static_cast<double>(count), static_cast<double>(expected.size()), 1.0);
}

TEST(PoseSource, IsSilentFrozenWrongOrNotANumberOnRequest) {
  PoseSource silent(PoseNumbers{}, 1);
  silent.set_faults({.silent = true});
  EXPECT_TRUE(record(silent, 0.25).empty());

  PoseSource frozen(PoseNumbers{}, 1);
  frozen.set_faults({.frozen = true});
  const auto poses = record(frozen, 0.25);
  EXPECT_EQ(poses.front().pose.position_w_m, poses.back().pose.position_w_m);
  EXPECT_NE(poses.front().pose.captured, poses.back().pose.captured);

  PoseSource broken(PoseNumbers{}, 1);
  broken.set_faults({.not_finite = true});
  EXPECT_TRUE(std::isnan(record(broken, 0.25).front().pose.position_w_m.x()));

  PoseSource turned(PoseNumbers{}, 1);
  turned.set_faults({.turn_rad = core::kPi});
  EXPECT_NEAR(record(turned, 1.0).back().pose.position_w_m.x(), -0.97, 0.01);
}

TEST(PoseSource, DropsOutAsOftenAndAsLongAsStated) {
  const auto poses = record({.dropout_per_s = 1.0, .dropout_s = 0.1}, 100.0, 5);
  // A dropout cannot begin during another one: the expected lost share is 0.1 / 1.1; three sigmas of 100 dropouts.
  EXPECT_NEAR(static_cast<double>(poses.size()), 10000.0 * (1.0 - 0.1 / 1.1), 300.0);
  // Catches dropouts that prolong each other: half a second became up to a second.
  const auto often = record({.dropout_per_s = 5.0, .dropout_s = 0.1}, 100.0, 5);
  EXPECT_NEAR(static_cast<double>(often.size()), 10000.0 * (1.0 - 0.5 / 1.5), 365.0);
}

}  // namespace
}  // namespace m100::sim
