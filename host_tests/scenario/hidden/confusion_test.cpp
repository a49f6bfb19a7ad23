// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/hidden/confusion.h"
#include "host_tests/lab/hidden/effect_sizes.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace m100::lab::hidden {
namespace {

/// Promise R13 on logs of simulators that share no code with the analysis.
class Translation : public ::testing::TestWithParam<std::string> {};

TEST_P(Translation, NamesAHiddenEffectOfMediumSize) {
  RecordProperty("promise", "R13");
  Case hidden_case;
  hidden_case.plan.axis = "translation";
  hidden_case.plan.seed = 1001;
  hidden_case.plan.logs_thrust =
      GetParam() == "thrust_gain" || GetParam() == "thrust_lag" || GetParam() == "axial_inflow";
  hidden_case.plan.hidden[GetParam()] = size_of(GetParam(), 1, 1001);
  hidden_case.declare = {"rigid_body"};
  hidden_case.expected = {{GetParam()}};
  hidden_case.verdict = "explained";
  hidden_case.group = "single";
  const Outcome outcome = analyse(hidden_case);
  EXPECT_EQ(outcome.failure, "");
  EXPECT_EQ(outcome.found, std::vector<std::string>{GetParam()});
  EXPECT_EQ(outcome.verdict, "explained") << (outcome.unexplained.empty() ? "" : outcome.unexplained.front());
  EXPECT_LT(outcome.after, 0.8 * outcome.before) << "on data the fit has not seen";
}

INSTANTIATE_TEST_SUITE_P(Effects, Translation,
                         ::testing::Values("steady_wind", "body_bias", "linear_drag", "quadratic_drag", "tilt_gain",
                                           "yaw_misalignment", "time_offset", "periodic_wind", "thrust_gain",
                                           "thrust_lag"),
                         [](const auto& tested) { return tested.param; });

TEST(TranslationAlone, FindsNothingWhereNothingIsHidden) {
  RecordProperty("promise", "R13");
  for (const std::uint64_t seed : {11U, 12U, 13U, 14U}) {
    Case hidden_case;
    hidden_case.plan.axis = "translation";
    hidden_case.plan.seed = seed;
    hidden_case.plan.logs_thrust = seed % 2 == 0;
    hidden_case.declare = {"rigid_body"};
    const Outcome outcome = analyse(hidden_case);
    EXPECT_EQ(outcome.verdict, "nothing_missing") << "seed " << seed;
    EXPECT_TRUE(outcome.found.empty()) << "seed " << seed;
  }
}

// A force whose cause is not among the candidates must not get the name of one.
TEST(TranslationAlone, GivesNoNameToASlungLoad) {
  RecordProperty("promise", "R13");
  for (const std::uint64_t seed : {21U, 22U, 23U}) {
    Case hidden_case;
    hidden_case.plan.axis = "translation";
    hidden_case.plan.seed = seed;
    hidden_case.plan.hidden["slung_load"] = 0.25;
    hidden_case.declare = {"rigid_body"};
    const Outcome outcome = analyse(hidden_case);
    EXPECT_EQ(outcome.verdict, "unexplained") << "seed " << seed;
    EXPECT_TRUE(outcome.found.empty()) << "seed " << seed << " named " << outcome.found.front();
  }
}

// At constant heading, wind, bias and trim cannot be distinguished: if one is named, the others must be named with it.
TEST(TranslationAlone, SaysThatWindAndBiasAreOneAtConstantHeading) {
  Case hidden_case;
  hidden_case.plan.axis = "translation";
  hidden_case.plan.seed = 31;
  hidden_case.plan.constant_heading = true;
  hidden_case.plan.hidden["steady_wind"] = 0.5;
  hidden_case.declare = {"rigid_body"};
  const Outcome outcome = analyse(hidden_case);
  ASSERT_EQ(outcome.found.size(), 1U);
  const auto said = [&](const std::string& a, const std::string& b) {
    return std::any_of(outcome.not_separable.begin(), outcome.not_separable.end(), [&](const auto& group) {
      return std::find(group.begin(), group.end(), a) != group.end() &&
             std::find(group.begin(), group.end(), b) != group.end();
    });
  };
  EXPECT_TRUE(said("steady_wind", "body_bias"));
  EXPECT_TRUE(said(outcome.found[0], "trim_offset"));
}

}  // namespace
}  // namespace m100::lab::hidden
