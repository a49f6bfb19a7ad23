// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/scenario/margins/onset.h"

namespace m100::lab::experiments {
namespace {

// Compares the linear margins with the whole program in simulated flight: it must begin to swing at the delay margin.
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
