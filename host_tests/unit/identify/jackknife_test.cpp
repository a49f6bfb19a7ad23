// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/selection/jackknife.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <utility>
#include <vector>

namespace m100::lab::identify {
namespace {

/// One number per block. The model is their mean, whose interval is known from theory.
class Means final : public Family {
 public:
  explicit Means(std::vector<double> blocks) : blocks_(std::move(blocks)) {}
  std::size_t block_count() const override { return blocks_.size(); }
  std::size_t samples_in(std::size_t) const override { return 1; }
  Fit fit(const Structure& structure, std::span<const int> weights, const Fit*) const override {
    double sum = 0.0;
    double count = 0.0;
    for (std::size_t k = 0; k < blocks_.size(); ++k) {
      sum += weights[k] * blocks_[k];
      count += weights[k];
    }
    Fit out;
    out.structure = structure;
    out.parameters = {sum / count};
    return out;
  }
  std::vector<std::vector<double>> errors(const Fit&, std::span<const int>) const override { return {}; }
  std::vector<Edit> edits(const Structure&) const override { return {}; }
  Structure without(const Structure& structure, const std::string&) const override { return structure; }
  bool is_significant(const Fit&, const std::string&) const override { return true; }

 private:
  std::vector<double> blocks_;
};

Interval interval_of(const Means& family, std::size_t refits) {
  const Fit fit = family.fit({}, std::vector<int>(family.block_count(), 1), nullptr);
  return jackknife(
             family, fit, [](const Fit& one) { return one.parameters; }, refits)
      .front();
}

// For a mean the jackknife gives the textbook interval: t(9) = 2.2622 times the standard error of ten numbers.
TEST(Jackknife, OfAMeanIsStudentsInterval) {
  const Interval found = interval_of(Means({3, 1, 4, 1, 5, 9, 2, 6, 5, 3}), 40);
  EXPECT_NEAR(found.value, 3.9, 1e-12);
  EXPECT_NEAR(found.high - found.value, 2.2622 * std::sqrt(54.9 / 9.0 / 10.0), 2e-3);
  EXPECT_NEAR(found.value - found.low, found.high - found.value, 1e-12);
}

// Catches intervals that are too narrow for few blocks, as bootstrap quantiles are (86 % coverage with ten blocks).
TEST(Jackknife, HoldsTheTruthInNineteenOfTwentyLogsOfTenBlocks) {
  constexpr int kLogs = 2000;
  std::mt19937_64 random(20261123);
  std::normal_distribution<double> normal;
  int held = 0;
  for (int log = 0; log < kLogs; ++log) {
    std::vector<double> blocks(10);
    for (double& block : blocks) {
      block = normal(random);
    }
    const Interval found = interval_of(Means(blocks), 40);
    held += found.low <= 0.0 && 0.0 <= found.high ? 1 : 0;
  }
  EXPECT_NEAR(static_cast<double>(held) / kLogs, 0.95, 0.02);  // four standard errors for 2000 logs
}

// Catches a number of fits that grows with the log: one hour has 1440 blocks.
TEST(Jackknife, OfALongLogLeavesOutGroupsOfBlocks) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  std::vector<double> blocks(1440);
  for (double& block : blocks) {
    block = normal(random);
  }
  const Interval found = interval_of(Means(blocks), 1000);
  EXPECT_NEAR(found.high - found.value, 2.02 / std::sqrt(1440.0), 0.4 / std::sqrt(1440.0));
}

TEST(Jackknife, WithoutRefitsIsTheValueAlone) {
  const Interval found = interval_of(Means({1, 2, 3}), 0);
  EXPECT_EQ(found.low, found.value);
  EXPECT_EQ(found.high, found.value);
}

}  // namespace
}  // namespace m100::lab::identify
