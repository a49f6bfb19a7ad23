// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/scenario/loop/hidden_plants.h"

namespace m100::tools::loop {
namespace {

TEST(Loop, IsThirtyPerCentBetterOnOneHiddenPlant) { EXPECT_LT(change_on(plants().front()), -0.3); }

}  // namespace
}  // namespace m100::tools::loop
