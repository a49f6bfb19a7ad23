// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/scenario/loop/hidden_plants.h"

namespace m100::lab::loop {
namespace {

TEST(Loop, IsThirtyPerCentBetterOnOneHiddenPlant) { EXPECT_LT(errors_on(kHiddenPlants.front()).change(), -0.3); }

TEST(Loop, FindsNothingWhereTheVehicleFileIsThePlant) { expect_nothing_found(1); }

}  // namespace
}  // namespace m100::lab::loop
