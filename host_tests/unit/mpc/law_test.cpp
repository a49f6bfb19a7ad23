// SPDX-License-Identifier: BSD-3-Clause
// The names of the laws, and how both behave at the limits and with values that are not numbers.
#include "firmware/mpc/law.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "firmware/mpc/generated/gain_table.h"
#include "firmware/mpc/horizontal_mpc.h"

namespace m100::mpc {
namespace {

TEST(LawWords, AreReadAsTheyAreWritten) {
  for (const Law law : {Law::kMpc, Law::kLqr}) {
    EXPECT_EQ(law_of(name(law)), law) << name(law);
  }
  EXPECT_EQ(law_of("pid"), std::nullopt);
  EXPECT_EQ(name(static_cast<Law>(99)), "") << "a byte of a damaged log";
}

class BothLaws : public ::testing::TestWithParam<Law> {
 protected:
  const GainTable<double>& table_ = generated::kX<double>;
  HorizontalMpc<double> mpc_{table_, GetParam()};
};
INSTANTIATE_TEST_SUITE_P(Laws, BothLaws, ::testing::Values(Law::kMpc, Law::kLqr),
                         [](const auto& tested) { return std::string(name(tested.param)); });

// Catches limits that shift with the trim: the command itself must keep them, whatever tilt the vehicle makes of it.
TEST_P(BothLaws, KeepTheLimitsOfTheCommandBesideATrim) {
  for (const double offset_rad : {0.0, 0.05, -0.05}) {
    Problem<double> problem;
    problem.input_offset_slope = offset_rad;
    problem.state[0] = -20.0;
    EXPECT_NEAR(mpc_.solve(problem).input_slope[0], table_.input_max_slope, 1e-12) << offset_rad;
    problem.state[0] = 20.0;
    const Solution<double> solution = mpc_.solve(problem);
    EXPECT_NEAR(solution.input_slope[0], table_.input_min_slope, 1e-12) << offset_rad;
    EXPECT_EQ(solution.path, GetParam() == Law::kMpc ? Path::kActiveSet : Path::kClipped);
  }
  EXPECT_EQ(mpc_.counters().clipped, GetParam() == Law::kMpc ? 0U : 6U);
}

// Catches a command that is not a number: it must be the middle between the limits, and the path must say that it is
// not an optimum.
TEST_P(BothLaws, AnswerWhatIsNoNumberInTheMiddle) {
  Problem<double> problem;
  problem.state[1] = std::numeric_limits<double>::quiet_NaN();
  const Solution<double> solution = mpc_.solve(problem);
  EXPECT_EQ(solution.path, Path::kClipped);
  for (const double input_slope : solution.input_slope) {
    EXPECT_NEAR(input_slope, 0.5 * (table_.input_min_slope + table_.input_max_slope), 1e-12);
  }
  EXPECT_EQ(mpc_.counters().clipped, 1U);
}

}  // namespace
}  // namespace m100::mpc
