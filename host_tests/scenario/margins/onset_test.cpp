// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/scenario/margins/onset.h"

namespace m100::lab::experiments {
namespace {

// The whole program in simulated flight knows nothing of linear algebra: where it begins to swing, the margin says so.
TEST(Margins, TheFlightSwingsWhereTheyEndOnVirtualRc) {
  for (const unsigned vehicle : {1U, 2U}) {
    expect_onset_where_predicted(vehicle, link::Channel::kVirtualRc);
  }
}

TEST(Margins, TheFlightSwingsWhereTheyEndOnMovementControl) {
  for (const unsigned vehicle : {1U, 2U}) {
    expect_onset_where_predicted(vehicle, link::Channel::kMovement);
  }
}

}  // namespace
}  // namespace m100::lab::experiments
