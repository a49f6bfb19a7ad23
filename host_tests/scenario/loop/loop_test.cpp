// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/scenario/loop/hidden_plants.h"

namespace m100::lab::loop {
namespace {

TEST(Loop, IsThirtyPerCentBetterOnOneHiddenPlant) { EXPECT_LT(errors_on(kHiddenPlants.front()).change(), -0.3); }

TEST(Loop, FindsNothingWhereTheVehicleFileIsThePlant) { expect_nothing_found(1); }

// Seed 4 was refused a clean bill for roll and for pitch; all twenty are flown at night.
TEST(Loop, GivesAFileThatWasIdentifiedItsCleanBill) { EXPECT_EQ(without_a_clean_bill(4, M100_IDENTIFIED_VEHICLE), ""); }

}  // namespace
}  // namespace m100::lab::loop
