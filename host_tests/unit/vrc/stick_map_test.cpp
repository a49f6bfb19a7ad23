// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/vrc/stick_map.h"

#include <gtest/gtest.h>

#include <limits>

#include "firmware/model/axis_effects.h"
#include "firmware/model/paper.h"
#include "firmware/vrc/command_map.h"

namespace m100::vrc {
namespace {

// Numbers of the paper: Table I (scale), III-B.3 (trim), III-B.5 (dead zone).
constexpr StickMap kRoll{.scale_si_per_vrc = 8.65e-4F, .neutral_vrc = 1080.F, .dead_zone_vrc = 19.8F};
constexpr StickMap kContinuous{.scale_si_per_vrc = 8.65e-4F,
                               .neutral_vrc = 998.F,
                               .dead_zone_vrc = 19.8F,
                               .shape = model::DeadZoneShape::kContinuous};
constexpr StickMap kYaw{.scale_si_per_vrc = 2.24e-3F, .dead_zone_vrc = 30.5F, .sign = -1.F};

struct Case {
  const char* name;
  StickMap map;
  float command_si;
  int expected;
};
void PrintTo(const Case& c, std::ostream* out) { *out << c.name << ": " << c.command_si << " -> " << c.expected; }

class StickMapTable : public ::testing::TestWithParam<Case> {};

// Catches a missing trim, a dead zone added on the wrong side, rounding towards zero, and a count that wraps beyond the
// travel.
TEST_P(StickMapTable, GivesTheStickOfTheTable) {
  RecordProperty("paper", "III-B.3, III-B.5, Table I");
  const core::Expected<Stick> stick = GetParam().map.to_stick(GetParam().command_si);
  ASSERT_TRUE(stick.has_value());
  EXPECT_EQ(static_cast<int>(*stick), GetParam().expected);
}

INSTANTIATE_TEST_SUITE_P(
    Table, StickMapTable,
    ::testing::Values(Case{"ZeroIsTrimmedNeutral", kRoll, 0.F, 1080}, Case{"TinyLeavesTheDeadZone", kRoll, 1e-3F, 1100},
                      Case{"TinyNegativeLeavesItDownwards", kRoll, -1e-3F, 1060},
                      Case{"LinearRange", kRoll, 0.1F, 1196},  // 0.1 / 8.65e-4 = 115.6
                      Case{"SaturatesAtTravel", kRoll, 1.F, 1684}, Case{"SaturatesBelow", kRoll, -1.F, 364},
                      Case{"ContinuousCountsFromTheEdge", kContinuous, 0.1F, 1133},  // 115.6 + 19.8
                      Case{"ContinuousZeroIsNeutral", kContinuous, 0.F, 998},
                      Case{"YawLeftIsTheSmallerStick", kYaw, 0.5F, 801},  // 0.5 / 2.24e-3 = 223.2
                      Case{"HugeIsNotWrapped", kRoll, 1e30F, 1684}),
    [](const auto& tested) { return tested.param.name; });

TEST(StickMap, RefusesWhatIsNotANumber) {
  EXPECT_EQ(kRoll.to_stick(std::numeric_limits<float>::quiet_NaN()).status(), core::Status::kOutOfRange);
  EXPECT_EQ(kRoll.to_stick(std::numeric_limits<float>::infinity()).status(), core::Status::kOutOfRange);
  EXPECT_EQ(kRoll.to_stick(-std::numeric_limits<float>::infinity()).status(), core::Status::kOutOfRange);
}

class StickMapRoundTrip : public ::testing::TestWithParam<StickMap> {};

// Catches an inverse that ignores the curve, the asymmetry, the sign or the order of dead zone and curve.
TEST_P(StickMapRoundTrip, EveryStickComesBack) {
  const StickMap& map = GetParam();
  for (int counts = 364; counts <= 1684; ++counts) {
    const Stick stick{static_cast<std::uint16_t>(counts)};
    const float command = map.to_command(stick);
    const core::Expected<Stick> back = map.to_stick(command);
    ASSERT_TRUE(back.has_value());
    if (command != 0.F) {
      EXPECT_NEAR(static_cast<int>(*back), counts, 1) << "command " << command;  // one count: float rounding at .5
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Maps, StickMapRoundTrip,
                         ::testing::Values(kRoll, kContinuous, kYaw,
                                           StickMap{.scale_si_per_vrc = 9e-4F,
                                                    .neutral_vrc = 1010.F,
                                                    .dead_zone_vrc = 16.1F,
                                                    .shape = model::DeadZoneShape::kContinuous,
                                                    .exponent = 1.4F,
                                                    .gain_asymmetry = 1.1F}));

model::Vehicle paper_like() {
  model::Vehicle vehicle;
  for (model::StickAxis* axis : {&vehicle.roll, &vehicle.pitch}) {
    axis->dead_zone_counts = model::paper::kTiltDeadZone_vrc;
    axis->dead_zone_shape = model::DeadZoneShape::kJump;
  }
  vehicle.roll.trim_counts = model::paper::kRollBalance_vrc - model::paper::kNeutral_vrc;
  vehicle.climb.scale_per_count = model::paper::kScaleClimb_m_s_per_count.experiment;
  vehicle.yaw_rate.scale_per_count = model::paper::kScaleYawRate_rad_s_per_count.experiment;
  return vehicle;
}

// Catches an effect that the table says is inverted at the stick but the map does not invert: the law of the simulated
// aircraft must give the command back, to the count that a stick is rounded to.
TEST(CommandMap, InvertsEveryEffectThatTheTableSaysItInverts) {
  int inverted = 0;
  for (const model::AxisEffect& effect : model::kAxisEffects) {
    if (effect.in_flight != model::InFlight::kInvertedAtTheStick) {
      continue;
    }
    ++inverted;
    model::Vehicle vehicle;
    vehicle.roll.scale_per_count = 9e-4;
    vehicle.roll.*effect.numbers[0].member = effect.typical.size;
    const CommandMap map(vehicle);
    for (float wanted = -0.3F; wanted < 0.31F; wanted += 0.05F) {
      CommandMap fresh = map;  // no remainder of another command
      ctl::Command<float> command;
      command.roll_rad = wanted;
      const core::Expected<Sticks> sticks = fresh.to_sticks(command);
      ASSERT_TRUE(sticks.has_value());
      model::StickLaw<double> law(vehicle.roll, 0.01);
      const double counts = static_cast<int>(sticks->roll) - 1024.0;
      EXPECT_NEAR(law.command(counts, 0.0, 0.0), static_cast<double>(wanted), 1.5 * 9e-4) << effect.name;
    }
  }
  EXPECT_EQ(inverted, 4);
}

// Catches a relay about level: the plain map answers every small command with the edge of the dead zone.
TEST(CommandMap, TheMeanOfManySticksIsTheCommandInsideTheDeadZone) {
  RecordProperty("paper", "III-B.5");
  CommandMap map(paper_like());
  for (const float wanted : {0.F, 1e-3F, -5e-3F, 0.012F, 0.05F}) {
    map.reset();
    double sum = 0.0;
    for (int i = 0; i < 1000; ++i) {
      ctl::Command<float> command;
      command.roll_rad = wanted;
      const core::Expected<Sticks> sticks = map.to_sticks(command);
      ASSERT_TRUE(sticks.has_value());
      sum += static_cast<double>(map.to_command(*sticks).roll_rad);
    }
    EXPECT_NEAR(sum / 1000.0, static_cast<double>(wanted), 3e-5) << wanted;  // one edge of 17 mrad in 1000 sticks
  }
}

TEST(CommandMap, DirectionsAreThoseOfTheProtocol) {
  const CommandMap map(paper_like());
  CommandMap moving = map;
  const Sticks neutral = map.neutral();
  EXPECT_EQ(static_cast<int>(neutral.roll), 1080);
  const core::Expected<Sticks> sticks =
      moving.to_sticks({.roll_rad = 0.1F, .pitch_rad = 0.1F, .climb_m_s = 0.5F, .yaw_rate_rad_s = 0.5F});
  ASSERT_TRUE(sticks.has_value());
  EXPECT_GT(sticks->roll, neutral.roll);          // right side down: stick right
  EXPECT_GT(sticks->pitch, neutral.pitch);        // nose down: stick forward
  EXPECT_GT(sticks->throttle, neutral.throttle);  // up
  EXPECT_LT(sticks->yaw, neutral.yaw);            // counter-clockwise: stick left
}

TEST(CommandMap, ANumberThatIsNoneChangesNothing) {
  CommandMap map(paper_like());
  EXPECT_EQ(map.to_sticks({.climb_m_s = std::numeric_limits<float>::quiet_NaN()}).status(), core::Status::kOutOfRange);
  EXPECT_EQ(map.to_sticks({.roll_rad = std::numeric_limits<float>::infinity()}).status(), core::Status::kOutOfRange);
}

// Each member alone: one that is not checked would reach the sticks.
TEST(CommandMap, EachNumberThatIsNoneIsRefused) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  CommandMap map(paper_like());
  EXPECT_EQ(map.to_sticks({.roll_rad = nan}).status(), core::Status::kOutOfRange);
  EXPECT_EQ(map.to_sticks({.pitch_rad = nan}).status(), core::Status::kOutOfRange);
  EXPECT_EQ(map.to_sticks({.climb_m_s = nan}).status(), core::Status::kOutOfRange);
  EXPECT_EQ(map.to_sticks({.yaw_rate_rad_s = nan}).status(), core::Status::kOutOfRange);
}

// An axis that was not identified uses the paper's scale; nothing is divided by zero.
TEST(CommandMap, AnAxisWithoutAScaleHasThePapers) {
  RecordProperty("paper", "Table I");
  model::Vehicle unknown;
  for (model::StickAxis* axis : {&unknown.roll, &unknown.pitch, &unknown.climb, &unknown.yaw_rate}) {
    axis->scale_per_count = 0.0;
    axis->trim_counts = 7.0;
  }
  const CommandMap map(unknown);
  EXPECT_EQ(map.roll().scale_si_per_vrc, 8.65e-4F);
  EXPECT_EQ(map.pitch().scale_si_per_vrc, 8.44e-4F);
  EXPECT_EQ(map.throttle().scale_si_per_vrc, 2.65e-3F);
  EXPECT_EQ(map.yaw().scale_si_per_vrc, 2.24e-3F);
  EXPECT_EQ(map.yaw().sign, -1.F);
  for (std::size_t stick = 0; stick < 4; ++stick) {
    EXPECT_EQ(map.map(stick).neutral_vrc, 1031.F) << stick;
    EXPECT_EQ(map.map(stick).sign, stick == 3 ? -1.F : 1.F) << stick;
  }
  const Sticks neutral = map.neutral();
  for (const Stick stick : {neutral.roll, neutral.pitch, neutral.throttle, neutral.yaw}) {
    EXPECT_EQ(static_cast<int>(stick), 1031);
  }
}

// The rounding remainder is carried over to the next stick of the same axis, limited to the dead zone and a count.
TEST(CommandMap, CarriesAtMostTheDeadZoneAndACount) {
  model::Vehicle vehicle;
  vehicle.roll.scale_per_count = 1e-3;
  vehicle.roll.dead_zone_counts = 20.0;
  vehicle.roll.dead_zone_shape = model::DeadZoneShape::kJump;
  CommandMap map(vehicle);
  ctl::Command<float> far;
  far.roll_rad = 5.F;  // beyond the travel: the remainder can never be made up for
  ASSERT_TRUE(map.to_sticks(far).has_value());
  ctl::Command<float> none;
  const core::Expected<Sticks> after = map.to_sticks(none);
  ASSERT_TRUE(after.has_value());
  EXPECT_EQ(static_cast<int>(after->roll), 1024 + 21) << "21 counts were left over";
  EXPECT_EQ(static_cast<int>(map.to_sticks(none)->roll), 1024) << "and are paid back";
}

}  // namespace
}  // namespace m100::vrc
