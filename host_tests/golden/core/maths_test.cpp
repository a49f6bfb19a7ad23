// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "host_tests/golden/core/maths_sweep.h"

namespace m100::golden {
namespace {

// Would catch: a call of libm, a contraction to a fused multiply-add, or a changed coefficient on this machine.
TEST(MathsSweep, DoubleHasTheBitsOfEveryOtherMachine) {
  RecordProperty("promise", "R6");
  EXPECT_EQ(view(maths_sweep<double>(kSweepRounds)), kSweepOfDouble);
}

TEST(MathsSweep, FloatHasTheBitsOfEveryOtherMachine) {
  RecordProperty("promise", "R6");
  EXPECT_EQ(view(maths_sweep<float>(kSweepRounds)), kSweepOfFloat);
}

}  // namespace
}  // namespace m100::golden
