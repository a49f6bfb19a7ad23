// SPDX-License-Identifier: BSD-3-Clause
// Where the limits bind, the law that knows them is the better one: the table of experiments/README.md, one seed of it.
#include <gtest/gtest.h>

#include "firmware/mpc/generated/gain_table.h"
#include "host_tests/lab/experiments/far.h"
#include "host_tests/lab/experiments/motion.h"

namespace m100::lab::experiments {
namespace {

// Catches an LQR that flies under both names, and an exact law that forgets its limits.
TEST(FarTasks, TheExactLawOvershootsFarLessThanTheClippedLqr) {
  SuiteOptions options;
  options.plant = sim::measured_plant();
  options.vehicle = companion::as_file(mpc::generated::kVehicle);
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

// Catches an overshoot counted before the fence, and one counted from where the reference was told to go.
TEST(FarTasks, AScoreCountsFromWhereTheFlightCameToRest) {
  FarTask task{.name = "fence", .course = "", .from_s = 0.0, .to_s = 4.0, .fence_high_m = 1.0};
  Trace trace;
  for (int i = 0; i < 400; ++i) {
    TracePoint point{.t_s = 0.01 * i};
    point.reference_m = {point.t_s, 0.0, 0.0};
    point.position_m = {i < 100 ? point.t_s : i < 150 ? 1.25 : 1.0, 0.0, 0.0};
    point.rung = 1;
    trace.push_back(point);
  }
  const FarScore score = far_score(trace, task);
  EXPECT_NEAR(score.overshoot_m, 0.25, 1e-9);
  EXPECT_NEAR(score.iae_m_s, 0.125, 1e-3);
  EXPECT_EQ(score.stayed, 1);
  trace[200].rung = 3;
  EXPECT_EQ(far_score(trace, task).stayed, 0);
}

// Catches a row whose weights never reach the table, and a calm command that would be free.
TEST(Motion, OfTheCommandFallsWithTheInputWeightAndCostsTrackingError) {
  SuiteOptions options;
  options.plant = sim::measured_plant();
  options.vehicle = companion::as_file(mpc::generated::kVehicle);
  const std::vector<MotionPoint> points = fly_motion(options);
  ASSERT_GT(points.size(), 3U);
  for (std::size_t i = 1; i < points.size(); ++i) {
    EXPECT_GT(points[i].input_weight, points[i - 1].input_weight);
    EXPECT_LT(points[i].hover.input_variation_deg_s, points[i - 1].hover.input_variation_deg_s);
    EXPECT_LT(points[i].square.input_variation_deg_s, points[i - 1].square.input_variation_deg_s);
  }
  EXPECT_GT(points.back().hover.pose_m, points.front().hover.pose_m);
}

}  // namespace
}  // namespace m100::lab::experiments
