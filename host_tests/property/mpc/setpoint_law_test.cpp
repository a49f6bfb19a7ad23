// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/gains/setpoint/setpoint_law.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "firmware/mpc/generated/gain_table.h"
#include "firmware/mpc/horizontal_mpc.h"
#include "host_tests/lab/gains/gain_tables.h"
#include "host_tests/lab/gains/instances.h"
#include "host_tests/lab/gains/setpoint/setpoint_regions.h"

namespace m100::lab::gains {
namespace {

/// A constant reference and a random state in the law's box; every third one is small, with hardly any active limits.
mpc::Problem<double> constant_problem(std::mt19937& random, const mpc::GainTable<double>& table, bool rounded) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const double size = random() % 3 == 0 ? 0.1 : 1.0;
  std::array<double, 6> z{};
  for (std::size_t i = 0; i < z.size(); ++i) {
    z.at(i) = size * unit(random) * table.setpoint.box.at(i) * 0.999;
  }
  mpc::Problem<double> problem;
  problem.position_ref_m.fill(3.0);
  problem.input_offset_slope = random() % 2 == 0 ? 0.03 * unit(random) : 0.0;
  const double tilt = table.input_gain * (z[5] + problem.input_offset_slope);
  problem.state = {3.0 + z[0], z[1], z[2] + tilt, table.states == 4 ? z[3] : 0.0};
  problem.previous_input_slope = z[4] + z[5];
  problem.disturbance_m_s2 = -table.tilt_sign * table.acceleration_per_tilt * tilt;
  const auto digits = [rounded](double value) { return rounded ? std::round(value * 1e6) / 1e6 : value; };
  problem.tilt_ref_slope.fill(digits(tilt));
  problem.input_ref_slope.fill(digits(z[5]));
  problem.constant_targets = true;
  problem.constant_reference = true;
  return problem;
}

/// The problem of one point of the box, in the units of the set-point law; `sign` mirrors it.
mpc::Problem<double> problem_at(const ParametricProgram& program, const mpc::GainTable<double>& table,
                                const Eigen::VectorXd& scaled, double sign) {
  std::array<double, mpc::kSetpointStates> z{};
  for (Eigen::Index j = 0; j < program.size(); ++j) {
    z.at(program.slot(j)) = sign * scaled[j] * program.box().at(program.slot(j));
  }
  const double tilt = table.input_gain * z[5];
  mpc::Problem<double> problem;
  problem.state = {z[0], z[1], z[2] + tilt, table.states == 4 ? z[3] : 0.0};
  problem.previous_input_slope = z[4] + z[5];
  problem.disturbance_m_s2 = -table.tilt_sign * table.acceleration_per_tilt * tilt;
  problem.tilt_ref_slope.fill(tilt);
  problem.input_ref_slope.fill(z[5]);
  problem.constant_targets = true;
  problem.constant_reference = true;
  return problem;
}

/// Largest number of changes of the active set in the preview law over problems of the box.
struct MaxChanges {
  std::size_t regions = 0;   ///< critical regions in half the box; the other half is its mirror image
  std::uint16_t cold = 0;    ///< from the empty set, for a point inside each region and its corners
  std::uint16_t kept = 0;    ///< from the active set of each region to a point of each region of the half box
  std::uint32_t failed = 0;  ///< problems that neither the iteration nor the table solved
};

MaxChanges max_changes(const AxisQp& axis) {
#ifdef M100_SANITIZED
  constexpr std::size_t kEvery = 19;  // instrumented code tests only every 19th
#else
  constexpr std::size_t kEvery = 1;
#endif
  constexpr double kInside = 0.99;  // share of the way from the middle to a corner
  ParametricProgram program(axis, kSetpointBox);
  ComputeBudget budget;
  const SetpointProgress nobody;
  const ConstructionContext work(budget, nobody);
  const Regions regions(program, work);
  const mpc::GainTable<double> table = make_gain_table(axis);
  mpc::HorizontalMpc<double> law(table);
  mpc::Solution<double> solution;
  MaxChanges max{.regions = regions.all().size()};
  const auto changes = [&](const mpc::Problem<double>& problem) {
    law.solve_preview(problem, solution);
    max.failed += solution.path == mpc::Path::kClipped ? 1U : 0U;
    return solution.changes;
  };
  std::vector<mpc::Problem<double>> inside, both;
  for (const Region& region : regions.all()) {
    Eigen::VectorXd middle = Eigen::VectorXd::Zero(program.size());
    for (const Eigen::VectorXd& corner : region.corners) {
      middle += corner / static_cast<double>(region.corners.size());
    }
    for (const Eigen::VectorXd& corner : region.corners) {
      law.reset();
      max.cold =
          std::max(max.cold, changes(problem_at(program, table, kInside * corner + (1.0 - kInside) * middle, 1.0)));
    }
    inside.push_back(problem_at(program, table, middle, 1.0));
    both.push_back(inside.back());
    both.push_back(problem_at(program, table, middle, -1.0));
    law.reset();
    max.cold = std::max(max.cold, changes(inside.back()));
  }
  for (std::size_t from = 0; from < both.size(); from += kEvery) {
    for (const mpc::Problem<double>& to : inside) {
      (void)changes(both[from]);
      max.kept = std::max(max.kept, changes(to));
    }
  }
  return max;
}

struct Difference {
  double double_rad = 0.0;
  double float_rad = 0.0;
  unsigned outside = 0;
};

template <typename Table, typename TableF>
Difference compare(const Table& table, const TableF& table_f, bool rounded, int count, unsigned seed) {
  std::mt19937 random(seed);
  mpc::HorizontalMpc<double> controller(table);
  mpc::HorizontalMpc<float> single(table_f);
  Difference out;
  for (int i = 0; i < count; ++i) {
    const mpc::Problem<double> problem = constant_problem(random, table, rounded);
    mpc::Solution<double> preview;
    controller.solve_preview(problem, preview);
    const mpc::Solution<double> setpoint = controller.solve(problem);
    out.outside += setpoint.path != mpc::Path::kSetpoint ? 1U : 0U;
    out.double_rad = std::max(out.double_rad, std::abs(setpoint.input_slope[0] - preview.input_slope[0]));
    out.float_rad = std::max(
        out.float_rad,
        std::abs(static_cast<double>(single.solve(to_float(problem)).input_slope[0]) - preview.input_slope[0]));
  }
  return out;
}

// The two exact laws share only H. Catches a missed or doubled region, a plane on the wrong side, and a leaf that
// covers one region too many: each gives an error of more than a milliradian somewhere.
TEST(SetpointLaw, OfTheGeneratedTablesIsThePreviewLaw) {
  for (const auto& [table, table_f] : {std::pair{&mpc::generated::kX<double>, &mpc::generated::kX<float>},
                                       {&mpc::generated::kY<double>, &mpc::generated::kY<float>}}) {
    ASSERT_FALSE(table->setpoint.nodes.empty());
    const Difference difference = compare(*table, *table_f, false, 200000, 1);
    EXPECT_EQ(difference.outside, 0U);
    EXPECT_LE(difference.double_rad, 1e-9);
    EXPECT_LE(difference.float_rad, 2e-5);
  }
}

TEST(SetpointLaw, StaysExactWhenTheTargetsAreRoundedToSixDecimals) {
  const Difference difference = compare(mpc::generated::kX<double>, mpc::generated::kX<float>, true, 100000, 2);
  EXPECT_LE(difference.double_rad, 2e-6) << "tolerance: rounding may move a plane";
}

// A law for a first-order axis with the benchmark's weights: the trial's tables had 1081 regions in the whole box.
TEST(SetpointLaw, OfTheFirstOrderBenchmarkHasItsRegionsAndIsThePreviewLaw) {
  model::Vehicle vehicle;
  vehicle.pitch.time_constant_s = 0.087;
  vehicle.mpc.input = 35.0;
  const AxisQp problem = axis_qp(vehicle, Axis::kX);
  const SetpointRows rows = make_setpoint_law(problem);
  EXPECT_GT(rows.regions, 500U);
  EXPECT_LT(rows.regions, 700U);
  mpc::GainTable<double> table = make_gain_table(problem);
  const mpc::GainTable<float> table_f = to_float(table);
  attach(rows, table);
  const Difference difference = compare(table, table_f, false, 100000, 3);
  EXPECT_LE(difference.double_rad, 1e-9);
}

// Regression test: in this box, regions without a common facet touch, where an earlier version split a cell endlessly
// or for minutes.
TEST(SetpointLaw, OfABoxWithHardCornersIsThePreviewLaw) {
  const AxisQp problem = axis_qp(mpc::generated::kVehicle, Axis::kX);
  const SetpointRows rows = make_setpoint_law(problem, {6.0, 4.0, 0.5, 2.0, 0.6, 0.31, 2e-5, 2e-5});
  ASSERT_FALSE(rows.too_large);
  mpc::GainTable<double> table = make_gain_table(problem);
  const mpc::GainTable<float> table_f = to_float(table);
  attach(rows, table);
  EXPECT_LE(compare(table, table_f, false, 100000, 5).double_rad, 1e-9);
}

// The limit counts work, not time: every machine stops at the same place, with a clean answer instead of a hang.
TEST(SetpointLaw, IsGivenUpWhenItsAllowanceIsSpent) {
  const AxisQp problem = axis_qp(mpc::generated::kVehicle, Axis::kX);
  double progress_s = 0.0;
  for (const ComputeBudget budget : {ComputeBudget(2000), ComputeBudget(400'000, 1'000'000)}) {
    const SetpointRows rows = make_setpoint_law(problem, kSetpointBox, budget,
                                                [&](std::size_t, std::size_t, double spent) { progress_s = spent; });
    EXPECT_TRUE(rows.too_large);
    EXPECT_TRUE(rows.nodes.empty() && rows.planes.empty() && rows.laws.empty());
    EXPECT_GT(progress_s, 0.0);
  }
}

// Where the set-point law answers, the iteration over active sets does not run. This test measures how many changes it
// would need there: every critical region of the box is an active set, and all of them are known.
TEST(SetpointLaw, TheMostChangesOfTheActiveSetInItsBoxByEnumeration) {
  std::string cold, kept;
  for (const Axis axis : {Axis::kX, Axis::kY}) {
    const MaxChanges max = max_changes(axis_qp(mpc::generated::kVehicle, axis));
    EXPECT_GT(max.regions, 400U);
    EXPECT_EQ(max.failed, 0U);
    EXPECT_LE(max.cold, mpc::kHorizon + 4) << "from the empty set, few changes should be reversed";
    EXPECT_LE(max.kept, 3 * mpc::kMaxChanges / 4) << "a quarter of the limit must remain";
    cold += (cold.empty() ? "" : ", ") + std::to_string(max.cold);
    kept += (kept.empty() ? "" : ", ") + std::to_string(max.kept);
  }
#ifndef M100_SANITIZED
  RecordProperty("figure.box_changes.cold", cold);
  RecordProperty("figure.box_changes.kept", kept);
#endif
}

TEST(SetpointLaw, LeavesWhatIsOutsideItsBoxToThePreviewLaw) {
  mpc::HorizontalMpc<double> controller(mpc::generated::kX<double>);
  std::mt19937 random(4);
  mpc::Problem<double> problem = constant_problem(random, mpc::generated::kX<double>, false);
  problem.state[0] = 3.0 + 6.01;
  EXPECT_NE(controller.solve(problem).path, mpc::Path::kSetpoint);
  problem.state[0] = std::nan("");
  EXPECT_EQ(controller.solve(problem).path, mpc::Path::kClipped);
}

}  // namespace
}  // namespace m100::lab::gains
