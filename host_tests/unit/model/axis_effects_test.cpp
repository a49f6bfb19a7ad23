// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/model/axis_effects.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

namespace m100::model {
namespace {

// Would catch contradictory bounds, and a fit that starts at or outside of a bound, where it cannot move.
TEST(AxisEffects, FitsBeginInsideOfTheirBounds) {
  for (const AxisEffect& effect : kAxisEffects) {
    for (std::size_t n = 0; n < effect.numbers.size(); ++n) {
      const AxisNumber& number = effect.numbers[n];
      SCOPED_TRACE(std::string(effect.name) + ", " + std::string(number.parameter));
      EXPECT_LT(number.fit.low, number.fit.high);
      EXPECT_TRUE(!number.logarithmic || number.fit.low > 0.0) << "a logarithm has no zero";
      EXPECT_GT(number.step, 0.0);
      for (const auto& start : effect.starts) {
        EXPECT_GT(start[n], number.fit.low);
        EXPECT_LT(start[n], number.fit.high);
      }
    }
    EXPECT_TRUE(effect.numbers.size() == 0 || effect.starts.size() > 0) << effect.name << " is never begun";
  }
}

// Would catch a delay that a fit may find but that no vehicle file may hold.
TEST(AxisEffects, ADelayThatIsFoundCanStandInAFile) {
  for (const AxisEffect& effect : kAxisEffects) {
    for (const AxisNumber& number : effect.numbers) {
      if (number.member == &StickAxis::transport_delay_s) {
        EXPECT_EQ(number.fit.low, 0.0) << effect.name;
        EXPECT_LE(number.fit.high, number.file.range[static_cast<std::size_t>(AxisUnit::kClimb_m_s)].high)
            << effect.name;
      }
    }
  }
}

TEST(AxisEffects, HaveNamesAndKeysOfTheirOwn) {
  for (std::size_t a = 0; a < kAxisEffects.size(); ++a) {
    for (std::size_t b = a + 1; b < kAxisEffects.size(); ++b) {
      EXPECT_NE(kAxisEffects[a].name, kAxisEffects[b].name);
    }
    for (const std::string_view other : {kAxisEffects[a].needs, kAxisEffects[a].not_beside}) {
      EXPECT_TRUE(other.empty() || std::any_of(kAxisEffects.begin(), kAxisEffects.end(),
                                               [&](const AxisEffect& effect) { return effect.name == other; }))
          << kAxisEffects[a].name << " names " << other;
    }
    for (const AxisNumber& number : kAxisEffects[a].numbers) {
      for (const AxisUnit unit : {AxisUnit::kTilt_rad, AxisUnit::kYawRate_rad_s, AxisUnit::kClimb_m_s}) {
        const Bounds range = number.file.range[static_cast<std::size_t>(unit)];
        EXPECT_TRUE(!number.file.exists(unit) || range.low < range.high) << number.parameter;
      }
    }
  }
}

// Exactly two effects are base models, to which the search adds the others. Catches a base model that is no longer
// marked as one.
TEST(AxisEffects, TwoAreTheModelsThatTheOthersAreAddedTo) {
  const auto bases = std::count_if(kAxisEffects.begin(), kAxisEffects.end(), is_base);
  EXPECT_EQ(bases, 2);
  EXPECT_FALSE(is_base(*axis_effect("dead_zone")));
}

}  // namespace
}  // namespace m100::model
