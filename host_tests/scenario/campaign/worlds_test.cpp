// SPDX-License-Identifier: BSD-3-Clause
// One flight in each world that ships: ten of each task are in the README, thousands in the soak test.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "firmware/mpc/generated/gain_table.h"
#include "host_tests/lab/campaign/outcome.h"
#include "host_tests/sim/world/plant_file.h"

namespace m100::lab::campaign {
namespace {

std::vector<std::string> worlds() {
  std::vector<std::string> paths;
  for (const auto& entry : std::filesystem::directory_iterator(M100_WORLDS)) {
    paths.push_back(entry.path().string());
  }
  std::sort(paths.begin(), paths.end());
  return paths;
}

class ShippedWorld : public ::testing::TestWithParam<std::string> {};

TEST_P(ShippedWorld, IsStayedInWithAStepOfThreeMetres) {
  const Settings settings{.vehicle = companion::as_file(mpc::generated::kVehicle)};
  const Outcome flown = fly_one(sim::load_plant(GetParam()), tasks_of("step_3m").front(), 1, settings);
  EXPECT_TRUE(flown.stayed) << flown.why << " at " << flown.failed_at_s << " s";
  EXPECT_FALSE(flown.breached);
  EXPECT_LT(flown.worst_tilt_deg, 35.0);  // promise R12
}
INSTANTIATE_TEST_SUITE_P(Campaign, ShippedWorld, ::testing::ValuesIn(worlds()),
                         [](const auto& tested) { return std::filesystem::path(tested.param).stem().string(); });

}  // namespace
}  // namespace m100::lab::campaign
