// SPDX-License-Identifier: BSD-3-Clause
// Pairs of effects that hide each other, and the memory of values that were used last.
#include "host_tests/lab/identify/model/axis/axis_pairs.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "host_tests/lab/identify/model/translation/recently_used.h"

namespace m100::lab::identify {
namespace {

constexpr Eigen::Index kSamples = 200;

Eigen::VectorXd series(double frequency, double phase) {
  Eigen::VectorXd out(kSamples);
  for (Eigen::Index k = 0; k < kSamples; ++k) {
    out(k) = std::sin(frequency * static_cast<double>(k) + phase);
  }
  return out;
}

// Catches a search that ranks single effects: each of the two explains a hundredth of what both explain together.
TEST(AxisPairs, TwoEffectsThatCancelEachOtherAreOffered) {
  const Eigen::VectorXd common = series(0.1, 0.0);
  const Eigen::VectorXd small = series(0.37, 1.0);
  const std::vector<EditDirection> directions{{"zone", common + 0.1 * small},
                                              {"trim", -common + 0.1 * small},
                                              {"curve", series(0.2, 0.3)},
                                              {"lag", 0.3 * series(0.37, 1.0) + series(0.6, 0.0)}};
  const auto pairs = best_pairs(5.0 * small, Eigen::MatrixXd(kSamples, 0), directions, 1);
  ASSERT_EQ(pairs.size(), 1U);
  EXPECT_EQ(pairs[0].first, "zone");
  EXPECT_EQ(pairs[0].second, "trim");
}

TEST(AxisPairs, OnlyForwardStepsCountAndTheModelsOwnParametersDoNot) {
  const Eigen::VectorXd a = series(0.1, 0.0);
  const Eigen::VectorXd b = series(0.37, 1.0);
  EXPECT_TRUE(best_pairs(-a - b, Eigen::MatrixXd(kSamples, 0), {{"a", a}, {"b", b}}, 3).empty());
  EXPECT_EQ(best_pairs(a + b, Eigen::MatrixXd(kSamples, 0), {{"a", a}, {"b", b}}, 3).size(), 1U);
  Eigen::MatrixXd base(kSamples, 1);
  base.col(0) = a;
  EXPECT_TRUE(best_pairs(a + b, base, {{"a", a}, {"b", b}}, 3).empty()) << "a is the model's own";
  EXPECT_TRUE(best_pairs(a + b, Eigen::MatrixXd(kSamples, 0), {{"a", a}, {"a", b}}, 3).empty())
      << "one effect, two starts";
}

TEST(RecentlyUsed, DropsTheValueThatWasUsedLongestAgo) {
  RecentlyUsed<int, int, std::hash<int>> kept;
  kept.keep(1, 10, 2);
  kept.keep(2, 20, 2);
  EXPECT_EQ(*kept.find(1), 10);
  kept.keep(3, 30, 2);
  EXPECT_EQ(kept.find(2), nullptr);
  EXPECT_EQ(*kept.find(1), 10);
  EXPECT_EQ(*kept.find(3), 30);
}

}  // namespace
}  // namespace m100::lab::identify
