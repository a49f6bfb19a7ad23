// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/core/cached_sin_cos.h"

#include <gtest/gtest.h>

#include <array>
#include <limits>

namespace m100::core {
namespace {

// Catches a cached turn that is used for another angle, and one that differs from sin_cos_of().
TEST(CachedSinCos, IsTheTurnOfTheAngleThatIsAskedFor) {
  CachedSinCos<float> standing;
  constexpr std::array kAngles{0.F, 0.1F, 0.1F, -2.5F, 0.1F, 0.F, 400.F, -0.7F, -0.7F};
  for (const float angle_rad : kAngles) {
    const SinCos<float> expected = sin_cos_of(angle_rad);
    const SinCos<float>& turn = standing.of(angle_rad);
    EXPECT_EQ(turn.sine, expected.sine) << angle_rad;
    EXPECT_EQ(turn.cosine, expected.cosine) << angle_rad;
  }
}

TEST(CachedSinCos, AnAngleThatIsNoNumberLeavesNoneBehind) {
  CachedSinCos<float> standing;
  EXPECT_FALSE(standing.of(std::numeric_limits<float>::quiet_NaN()).sine == 0.F);
  EXPECT_EQ(standing.of(0.F).cosine, 1.F);
  EXPECT_EQ(standing.of(0.F).sine, 0.F);
}

}  // namespace
}  // namespace m100::core
