// SPDX-License-Identifier: BSD-3-Clause
// Streams whose samples arrive several at a time: the spread times against the times at which the samples were taken.
#include "host_tests/lab/logs/bunched_arrivals.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <random>

namespace m100::lab::logs {
namespace {

constexpr double kInterval_s = 0.01;
constexpr std::size_t kSamples = 3000;

double taken(std::size_t k) { return 100.0 + kInterval_s * static_cast<double>(k); }

/// The arrival of sample k: with the next delivery after it was taken, behind those of the same delivery.
double delivered(std::size_t k, double every_s) {
  const double delivery = std::ceil((taken(k) - 1e-9) / every_s) * every_s;
  return delivery + 1e-4 * (taken(k) - delivery + every_s) / kInterval_s;
}

std::vector<double> arrivals(double every_s) {
  std::vector<double> out(kSamples);
  for (std::size_t k = 0; k < kSamples; ++k) {
    out[k] = delivered(k, every_s);
  }
  return out;
}

/// Largest difference between the spread times and the true ones, apart from a common offset.
double worst_error(const std::vector<double>& time_s, const std::vector<std::size_t>& samples) {
  double low = 1e9;
  double high = -1e9;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    low = std::min(low, time_s[i] - taken(samples[i]));
    high = std::max(high, time_s[i] - taken(samples[i]));
  }
  EXPECT_GT(low, -2e-3) << "before it was taken";
  EXPECT_LT(high, kInterval_s + 2e-3) << "later than one sample";
  return high - low;
}

std::vector<std::size_t> all_samples() {
  std::vector<std::size_t> out(kSamples);
  for (std::size_t k = 0; k < kSamples; ++k) {
    out[k] = k;
  }
  return out;
}

class Bunches : public ::testing::TestWithParam<int> {};

// Catches a reader that keeps arrivals as times: four of five samples would lie up to 40 ms late.
TEST_P(Bunches, AreSpreadByTheRegularRate) {
  const std::vector<double> arrival_s = arrivals(1e-3 * GetParam());
  ASSERT_TRUE(are_bunched(arrival_s));
  const auto spread = spread_arrivals(arrival_s, {});
  ASSERT_TRUE(spread);
  EXPECT_FALSE(spread->by_counter);
  EXPECT_NEAR(spread->interval_s, kInterval_s, 1e-6);
  EXPECT_LT(worst_error(spread->time_s, all_samples()), 1e-3);
}
INSTANTIATE_TEST_SUITE_P(Milliseconds, Bunches, ::testing::Values(20, 33, 50, 51, 100));

TEST(BunchedArrivals, HolesInTheCounterAreLostMessages) {
  std::mt19937 random(3);
  std::vector<double> arrival_s;
  std::vector<double> counter;
  std::vector<std::size_t> samples;
  for (std::size_t k = 0; k < kSamples; ++k) {
    const bool in_hole = k > 1000 && k < 1200;
    if (!in_hole && random() % 10 != 0) {
      arrival_s.push_back(delivered(k, 0.05));
      counter.push_back(static_cast<double>((k + 60'000) % 65'536));  // it wraps once
      samples.push_back(k);
    }
  }
  const auto spread = spread_arrivals(arrival_s, counter);
  ASSERT_TRUE(spread);
  EXPECT_TRUE(spread->by_counter);
  EXPECT_LT(worst_error(spread->time_s, samples), 1e-3);
}

TEST(BunchedArrivals, ACounterMayStartAnewAndNeighboursMayBeStampedInTheWrongOrder) {
  std::vector<double> arrival_s = arrivals(0.05);
  std::vector<double> counter;
  for (std::size_t k = 0; k < kSamples; ++k) {
    counter.push_back(static_cast<double>(k < 1500 ? k : k - 1500));
  }
  for (std::size_t k = 100; k < kSamples; k += 400) {
    std::swap(arrival_s[k], arrival_s[k + 1]);
  }
  arrival_s[777] = 1e9;  // a spoilt stamp
  const auto spread = spread_arrivals(arrival_s, counter);
  ASSERT_TRUE(spread);
  EXPECT_TRUE(std::isnan(spread->time_s[777]));
  std::vector<double> rest = spread->time_s;
  rest[777] = taken(777);
  EXPECT_LT(worst_error(rest, all_samples()), kInterval_s);
}

// Random or jittering arrivals are the sensor's own times: spreading them would move samples.
TEST(BunchedArrivals, JitterAndIndependentArrivalsAreNoBunches) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> jitter(-0.003, 0.003);
  std::exponential_distribution<double> wait(100.0);
  std::vector<double> jittering;
  std::vector<double> poisson{0.0};
  for (std::size_t k = 0; k < kSamples; ++k) {
    jittering.push_back(taken(k) + jitter(random));
    poisson.push_back(poisson.back() + wait(random));
  }
  EXPECT_FALSE(are_bunched(jittering));
  EXPECT_FALSE(are_bunched(poisson));
}

TEST(BunchedArrivals, BunchesOfAChangingRateAreNotSpread) {
  std::vector<double> arrival_s;
  for (std::size_t k = 0; k < kSamples; ++k) {
    const auto bunch = static_cast<double>(k / 5);
    const double each_s = k < kSamples / 2 ? 0.05 : 0.1;  // from 100 to 50 samples a second
    const auto half = static_cast<double>(kSamples / 10);
    arrival_s.push_back(std::min(bunch, half) * 0.05 + std::max(0.0, bunch - half) * each_s +
                        1e-4 * static_cast<double>(k % 5));
  }
  ASSERT_TRUE(are_bunched(arrival_s));
  EXPECT_FALSE(spread_arrivals(arrival_s, {}));
}

}  // namespace
}  // namespace m100::lab::logs
