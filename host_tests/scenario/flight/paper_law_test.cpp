// SPDX-License-Identifier: BSD-3-Clause
// The law of the paper's authors in the measured plant and in the world of their flights.
#include <gtest/gtest.h>
#include <cmath>

#include "firmware/mpc/generated/gain_table.h"
#include "host_tests/lab/experiments/results.h"
#include "host_tests/sim/world/plant_file.h"

namespace m100::lab::experiments {
namespace {

/// Hover of the paper's law for 60 s.
Cell paper_hover(const sim::Plant& plant, std::uint64_t seed = 1) {
  FlightPlan plan;
  plan.plant = plant;
  plan.vehicle = companion::as_file(mpc::generated::kVehicle);
  plan.duration_s = 76.0;
  plan.seed = seed;
  return score(fly(in_paper_configuration(plan)).trace, 15.0, 75.0);
}

// With the Firefly's weights and the law's state from its own model the loop swung by 9.5 degrees of roll in this wind.
// A limit of twice what the paper measured catches every such cycle; the tilt of its wind alone is 0.93.
TEST(PaperLaw, HoversWithoutALimitCycleInCalmAirAndInTheFan) {
  RecordProperty("paper", "IV-D.2");
  const sim::Plant world = sim::load_plant("host_tests/sim/world/paper.toml");
  for (const sim::Plant& plant : {world, sim::with_fan(world), sim::with_fan(sim::measured_plant())}) {
    const Cell cell = paper_hover(plant);
    EXPECT_LT(cell.roll_deg, 2.0 * model::paper::kHoverWind.roll_deg);
    EXPECT_LT(cell.pitch_deg, 2.0 * model::paper::kHoverWind.pitch_deg);
    EXPECT_LT(cell.pose_m, 1.5 * model::paper::kHoverWind.pose_m);
  }
}

// What the paper's table says of the shape of the tilt's dead zone. Its stick rule flies a continuous one with half as
// much horizontal error again, on the measured plant, of which no number but the shape is changed.
TEST(PaperLaw, TellsTheShapeOfTheDeadZoneByItsCalmHover) {
  RecordProperty("paper", "III-B.5, IV-D.2");
  const auto horizontal_m = [](model::DeadZoneShape shape) {
    sim::Plant plant = sim::measured_plant();
    plant.roll.dead_zone_shape = plant.pitch.dead_zone_shape = shape;
    double sum_m = 0.0;
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      const Cell cell = paper_hover(plant, seed);
      sum_m += std::hypot(cell.x_m, cell.y_m) / 3.0;
    }
    return sum_m;
  };
  const double papers_m = std::hypot(model::paper::kHoverCalm.x_m, model::paper::kHoverCalm.y_m);
  EXPECT_NEAR(horizontal_m(model::DeadZoneShape::kJump), papers_m, 0.15 * papers_m);
  EXPECT_GT(horizontal_m(model::DeadZoneShape::kContinuous), 1.35 * papers_m);
}

}  // namespace
}  // namespace m100::lab::experiments
