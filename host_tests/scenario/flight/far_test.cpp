// SPDX-License-Identifier: BSD-3-Clause
// Where limits are active, the law that knows them is better: one seed of the table of experiments/README.md.
#include <gtest/gtest.h>

#include <sstream>

#include "firmware/companion/files/text/json.h"
#include "firmware/mpc/generated/gain_table.h"
#include "host_tests/lab/experiments/far.h"

namespace m100::lab::experiments {
namespace {

constexpr double kBlind = 100.0;  ///< dropouts a second with which no pose arrives: control is never taken

SuiteOptions measured(double dropout_per_s = 0.0) {
  SuiteOptions options;
  options.plan.plant = sim::measured_plant();
  options.plan.plant.pose.dropout_per_s = dropout_per_s;
  options.plan.vehicle = companion::as_file(mpc::generated::kVehicle);
  return options;
}

// Catches an LQR that flies under both names, and an exact law that ignores its limits.
TEST(FarTasks, TheExactLawOvershootsFarLessThanTheClippedLqr) {
  SuiteOptions options = measured();
  for (const char* const task : {"step_30m", "square_3m"}) {
    options.only = task;
    const std::vector<FarResult> results = fly_far(options);
    ASSERT_EQ(results.size(), 1U);
    const FarResult& result = results.front();
    EXPECT_EQ(result.mpc.stayed, 1) << task;
    EXPECT_EQ(result.lqr.stayed, 1) << task;
    EXPECT_LT(result.mpc.overshoot_m, 0.7 * result.lqr.overshoot_m) << task;
    EXPECT_LT(result.mpc.iae_m_s, 0.9 * result.lqr.iae_m_s) << task;
  }
}

// Catches a planner that never plans (the jump settles in 4.2 s), one that plans beyond the authority, and one that
// does not see that the aircraft tilts less than its file says.
TEST(FarTasks, ThePlannerSettlesSoonerAndLeavesTheAuthorityOfTheLowestGain) {
  SuiteOptions options = measured();
  options.only = "step_6m";
  const FarResult near = fly_far(options).front();
  EXPECT_EQ(near.planned.stayed, 1);
  EXPECT_LE(near.planned.settled_s, 2.8);
  EXPECT_LE(near.planned.overshoot_m, 0.6);
  EXPECT_LT(near.planned.iae_m_s, near.mpc.iae_m_s);
  options.only = "step_30m";
  EXPECT_LE(fly_far(options).front().planned.overshoot_m, 0.6);
  constexpr double kLowestGain = 0.8;
  options.plan.plant.roll.scale_per_count *= kLowestGain;
  options.plan.plant.pitch.scale_per_count *= kLowestGain;
  const FarResult weak = fly_far(options).front();
  EXPECT_EQ(weak.planned.stayed, 1);
  EXPECT_LE(weak.planned.overshoot_m, 2.5);
}

// Catches an overshoot that is counted before the fence, and one that is counted from the ordered end of the reference.
TEST(FarTasks, AScoreCountsFromWhereTheFlightCameToRest) {
  FarTask task{.name = "fence", .course = "", .from_s = 0.0, .to_s = 4.0, .fence_high_m = 1.0};
  Trace trace;
  for (int i = 0; i < 400; ++i) {
    TracePoint point{.t_s = 0.01 * i};
    point.reference_m = {point.t_s, 0.0, 0.0};
    point.position_m = {i < 100 ? point.t_s : i < 150 ? 1.25 : 1.0, 0.0, 0.0};
    point.failsafe_state = 1;
    trace.push_back(point);
  }
  const FarScore score = far_score(trace, task);
  EXPECT_NEAR(score.overshoot_m, 0.25, 1e-9);
  EXPECT_NEAR(score.iae_m_s, 0.125, 1e-3);
  EXPECT_EQ(score.stayed, 1);
  trace[200].failsafe_state = 3;
  EXPECT_EQ(far_score(trace, task).stayed, 0);
  EXPECT_EQ(far_score({}, task).stayed, 0) << "an empty trace counts as a flight that stayed";
}

// Catches a flight that never began and is counted as one without overshoot.
TEST(FarTasks, WhatNeverFlewHasNoErrorInsteadOfNone) {
  SuiteOptions options = measured(kBlind);
  options.only = "step_6m";
  const std::vector<FarResult> results = fly_far(options);
  EXPECT_EQ(not_flown(results), 3);
  const Json answer = far_to_json(results);
  for (const char* const law : {"planned", "mpc", "lqr"}) {
    const Json& one = answer.at("tasks").at(0).at(law);
    EXPECT_TRUE(one.at("overshoot_m").is_null()) << one;
    EXPECT_TRUE(one.at("iae_m_s").is_null()) << one;
    EXPECT_EQ(one.at("stayed"), 0);
    EXPECT_EQ(one.at("not_flown"), 1);
  }
  EXPECT_TRUE(answer.at("gain_iae").is_null());
  std::ostringstream said;
  print_far(said, results);
  EXPECT_NE(said.str().find("step_6m: not flown!"), std::string::npos) << said.str();
  EXPECT_EQ(said.str().find("better by"), std::string::npos) << said.str();
}

}  // namespace
}  // namespace m100::lab::experiments
