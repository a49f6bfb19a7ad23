// SPDX-License-Identifier: BSD-3-Clause
// Spoilt single samples of a log, and healthy samples that look like them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "host_tests/lab/identify/data/log_defects.h"
#include "host_tests/lab/identify/data/translation_repair.h"
#include "host_tests/unit/identify/one_log.h"

namespace m100::lab::identify {
namespace {

// Once 4 of 90 healthy logs had an "outlier" in a stick at 20 and 25 Hz: the sharpest turn of the hand.
TEST(SharpTurn, OfAHandIsNoOutlier) {
  std::vector<double> stick(1500, 0.0);
  const std::vector<double> turn{-20, -39, -81, -136, -139, -114, -75, -38, -6, 0};
  for (std::size_t at = 100; at < 1400; at += 250) {
    std::copy(turn.begin(), turn.end(), &stick[at]);
  }
  stick[50] = 280.0;
  stick[51] = 280.0;
  const std::vector<char> used(stick.size(), 1);
  EXPECT_TRUE(repair_stick(stick, used, {0.0, 0.04, 0.04}, "stick").empty());
  stick[700] = -140.0;  // differs from both neighbours
  EXPECT_EQ(repair_stick(stick, used, {0.0, 0.04, 0.04}, "stick").size(), 1U);
}

// Once the turning point of a roll that was logged at 10 Hz was an "outlier".
TEST(SlowRows, ASmoothTurnIsNoOutlier) {
  const std::vector<double> turn{0.069, 0.016, -0.060, -0.127, -0.178, -0.204, -0.181, -0.112, -0.042, 0.002, 0.0};
  std::vector<double> angle(600, 0.0);
  for (std::size_t k = 0; k < angle.size(); ++k) {
    angle[k] = 0.002 * std::sin(2.7 * static_cast<double>(k));  // air noise at rest
  }
  for (std::size_t at = 50; at < 550; at += 100) {
    std::copy(turn.begin(), turn.end(), &angle[at]);
  }
  std::vector<char> used(angle.size(), 1);
  const SampleGrid clock{0.0, 0.1, 0.1};
  EXPECT_TRUE(repair_samples(angle, used, clock, "attitude_roll").empty());
  angle[320] += 0.3;
  EXPECT_EQ(repair_samples(angle, used, clock, "attitude_roll").size(), 1U);
}

// Catches a spoilt sample that stays because another signal was not sampled at that time.
TEST(TranslationRepair, LooksAtTheGapsOfTheSignalItself) {
  logs::FlightLog log = healthy_flight("translation", 31);
  log.gap.assign(log.size, 1);
  log.signal_gap[logs::Signal::kRateX] = log.gap;
  log.of(logs::Signal::kAttitudeRoll)[2000] += 0.5;
  std::vector<Finding> findings;
  translation::repaired(log, {{3.0, 30.0}}, findings);
  EXPECT_EQ(findings.at(0).what, "outliers");
}

// Catches a freeze that ends when the vehicle passes the frozen value again, so that there is no jump at its end.
TEST(FrozenResponse, IsFoundWithoutAJumpAtItsEnd) {
  for (std::uint64_t seed = 31; seed <= 34; ++seed) {
    logs::FlightLog log = healthy_flight("roll", seed);
    std::vector<double> angle = log.of(logs::Signal::kAttitudeRoll);
    std::size_t begin = 1500;
    while (std::abs(angle[begin] - angle[begin - 1]) < 0.003) {
      ++begin;  // in the middle of a motion
    }
    const auto again =
        std::min_element(angle.begin() + static_cast<std::ptrdiff_t>(begin) + 100,
                         angle.begin() + static_cast<std::ptrdiff_t>(begin) + 700,
                         [&](double a, double b) { return std::abs(a - angle[begin]) < std::abs(b - angle[begin]); });
    std::fill(angle.begin() + static_cast<std::ptrdiff_t>(begin), again, angle[begin]);
    std::vector<char> used(log.size, 1);
    const std::vector<Finding> found = repair_samples(angle, used, {0.0, log.period_s, log.period_s}, "attitude_roll");
    ASSERT_EQ(found.size(), 1U) << seed;
    EXPECT_EQ(found.front().what, "frozen") << seed;
  }
}

}  // namespace
}  // namespace m100::lab::identify
