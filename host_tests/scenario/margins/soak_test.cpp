// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/scenario/margins/onset.h"

namespace m100::lab::experiments {
namespace {

class MarginsOfTenVehicles : public ::testing::TestWithParam<unsigned> {};

TEST_P(MarginsOfTenVehicles, TheFlightSwingsWhereTheyEnd) {
  expect_onset_where_predicted(GetParam(), link::Channel::kVirtualRc);
  expect_onset_where_predicted(GetParam(), link::Channel::kMovement);
}
INSTANTIATE_TEST_SUITE_P(Vehicle, MarginsOfTenVehicles, ::testing::Range(1U, 11U));

}  // namespace
}  // namespace m100::lab::experiments
