// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/vrc/stick_map.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
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

/// A count is 1 mrad, so that the numbers of a case can be read as counts.
constexpr StickMap kWhole{.scale_si_per_vrc = 1e-3F, .neutral_vrc = 1024.F, .dead_zone_vrc = 20.F};
constexpr StickMap kAsymmetric{.scale_si_per_vrc = 1e-3F, .neutral_vrc = 1024.F, .gain_asymmetry = 1.5F};
constexpr StickMap kAll{.scale_si_per_vrc = 1e-3F,
                        .neutral_vrc = 1014.F,
                        .dead_zone_vrc = 20.F,
                        .shape = model::DeadZoneShape::kContinuous,
                        .exponent = 2.F,
                        .gain_asymmetry = 1.5F,
                        .sign = -1.F};
constexpr StickMap kCurved{.scale_si_per_vrc = 1e-3F, .neutral_vrc = 1024.F, .exponent = 1.5F};

/// The trim lies between two counts, and there is no dead zone: neutral is a tenth of a count away.
constexpr StickMap kBetween{.scale_si_per_vrc = 1e-3F, .neutral_vrc = 1023.9F, .gain_asymmetry = 1.5F};

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
    ::testing::Values(
        Case{"ZeroIsTrimmedNeutral", kRoll, 0.F, 1080}, Case{"TinyLeavesTheDeadZone", kRoll, 1e-3F, 1100},
        Case{"TinyNegativeLeavesItDownwards", kRoll, -1e-3F, 1060},
        Case{"LinearRange", kRoll, 0.1F, 1196},  // 0.1 / 8.65e-4 = 115.6
        Case{"SaturatesAtTravel", kRoll, 1.F, 1684}, Case{"SaturatesBelow", kRoll, -1.F, 364},
        Case{"ContinuousCountsFromTheEdge", kContinuous, 0.1F, 1133},  // 115.6 + 19.8
        Case{"ContinuousZeroIsNeutral", kContinuous, 0.F, 998},
        Case{"YawLeftIsTheSmallerStick", kYaw, 0.5F, 801},  // 0.5 / 2.24e-3 = 223.2
        Case{"HugeIsNotWrapped", kRoll, 1e30F, 1684}, Case{"HugeNegativeIsNotWrapped", kRoll, -1e30F, 364},
        Case{"LinearRangeDownwards", kRoll, -0.1F, 964},  // 1080 - 115.6, to the nearest
        Case{"ContinuousCountsFromTheEdgeDownwards", kContinuous, -0.1F, 863},
        Case{"YawRightIsTheLargerStick", kYaw, -0.5F, 1247},
        Case{"JustInsideTheJumpIsPastItsEdge", kWhole, 19.9e-3F, 1045},
        Case{"AtTheJumpIsPastItsEdge", kWhole, 20e-3F, 1045}, Case{"BeyondTheJumpIsLinear", kWhole, 21e-3F, 1045},
        // Asymmetry 1.5: to the positive side 2 * 1.5 / 2.5 = 1.2 of the mean gain, to the other 0.8.
        Case{"LessThanACountIsAsymmetricToo", kBetween, 0.49e-3F, 1024},  // 0.41 counts; 0.61 would be the next
        Case{"NothingIsJumpedWhereThereIsNoDeadZone", kBetween, -0.1e-3F, 1024},
        Case{"AsymmetricUp", kAsymmetric, 0.12F, 1124}, Case{"AsymmetricDown", kAsymmetric, -0.12F, 874},
        // All together: 330 counts from the edge are 165 of 660 after the curve, and 1.2 or 0.8 of that.
        Case{"AllUp", kAll, -0.198F, 1364}, Case{"AllDown", kAll, 0.132F, 664},
        // Exponent 2: half of the travel of 660 counts gives a quarter of the command.
        Case{"CurvedUp", kCurved, 0.0825F, 1189}, Case{"CurvedDown", kCurved, -0.0825F, 859}),
    [](const auto& tested) { return tested.param.name; });

// Catches an edge that is a whole number of counts, which does nothing, and a trim between two counts that moves the
// stick back inside by rounding.
TEST(StickMap, TheSmallestCommandGivesTheFirstStickOutsideOfTheJump) {
  for (float neutral = 1010.F; neutral < 1030.F; neutral += 0.3F) {
    for (float width = 0.75F; width < 33.F; width += 0.25F) {
      const StickMap map{.scale_si_per_vrc = 1e-3F, .neutral_vrc = neutral, .dead_zone_vrc = width};
      for (const float command : {1e-6F, -1e-6F}) {
        const core::Expected<Stick> stick = map.to_stick(command);
        ASSERT_TRUE(stick.has_value());
        const auto counts = static_cast<int>(*stick);
        const auto inner = static_cast<std::uint16_t>(command > 0.F ? counts - 1 : counts + 1);
        EXPECT_GT(map.to_command(*stick) * command, 0.F) << neutral << " " << width;
        // Nothing, or a stick that is on the edge but for the rounding of a float.
        EXPECT_LT(std::abs(map.to_command(Stick{inner})), 1e-3F * (width + 1e-3F)) << neutral << " " << width;
      }
    }
  }
}

TEST(StickMap, RefusesWhatIsNotANumber) {
  for (const float bad : {std::nanf(""), HUGE_VALF, -HUGE_VALF}) {
    EXPECT_EQ(kRoll.to_stick(bad).status(), core::Status::kOutOfRange);
  }
}

struct BackCase {
  const char* name;
  StickMap map;
  int counts;
  float command_si;
};
void PrintTo(const BackCase& c, std::ostream* out) { *out << c.name << ": " << c.counts << " -> " << c.command_si; }

class StickMapBackTable : public ::testing::TestWithParam<BackCase> {};

// Catches a dead zone that ends a count too early or too late, or on one side only, and a curve or asymmetry .
TEST_P(StickMapBackTable, GivesTheCommandOfTheTable) {
  EXPECT_NEAR(GetParam().map.to_command(Stick{static_cast<std::uint16_t>(GetParam().counts)}), GetParam().command_si,
              1e-6F);  // float rounding of a product
}

constexpr StickMap kWholeContinuous{.scale_si_per_vrc = 1e-3F,
                                    .neutral_vrc = 1024.F,
                                    .dead_zone_vrc = 20.F,
                                    .shape = model::DeadZoneShape::kContinuous};
INSTANTIATE_TEST_SUITE_P(Table, StickMapBackTable,
                         ::testing::Values(BackCase{"TheEdgeIsNothing", kWhole, 1044, 0.F},
                                           BackCase{"TheLowerEdgeIsNothing", kWhole, 1004, 0.F},
                                           BackCase{"BeyondTheEdgeItJumps", kWhole, 1045, 0.021F},
                                           BackCase{"BeyondTheLowerEdgeItJumps", kWhole, 1003, -0.021F},
                                           BackCase{"ContinuousBeginsAtTheEdge", kWholeContinuous, 1045, 0.001F},
                                           BackCase{"ContinuousBeginsAtTheLowerEdge", kWholeContinuous, 1003, -0.001F},
                                           BackCase{"AsymmetricUp", kAsymmetric, 1124, 0.12F},
                                           BackCase{"AsymmetricDown", kAsymmetric, 874, -0.12F},
                                           BackCase{"CurvedUp", kCurved, 1189, 0.0825F},
                                           BackCase{"CurvedDown", kCurved, 859, -0.0825F},
                                           BackCase{"LessThanACountIsSomething", kBetween, 1024, 0.00012F},
                                           BackCase{"AllUp", kAll, 1364, -0.198F},
                                           BackCase{"AllDown", kAll, 664, 0.132F},
                                           BackCase{"TheSignTurnsIt", kYaw, 801, 0.49952F}),
                         [](const auto& tested) { return tested.param.name; });

// The paper's rule in counts of 1 mrad, each command twice, so that a remainder of the first would show in the second.
// Catches a stick that rests inside the zone, an edge on the wrong side, and a zone added to a command outside of it.
TEST(CommandMap, ByThePapersRuleGoesToTheEdgeAndCarriesNothing) {
  RecordProperty("paper", "III-B.5");
  model::Vehicle vehicle;
  vehicle.roll.scale_per_count = vehicle.climb.scale_per_count = 1e-3;
  vehicle.roll.dead_zone_counts = model::paper::kTiltDeadZone_vrc;
  vehicle.climb.dead_zone_counts = model::paper::kClimbDeadZone_vrc;
  vehicle.roll.dead_zone_shape = vehicle.climb.dead_zone_shape = model::DeadZoneShape::kJump;
  CommandMap map(vehicle, StickRule::kAsThePaper);
  struct Row {
    float command_si;
    int roll, throttle;
  };
  for (const Row row : {Row{0.F, 1024, 1024}, Row{0.002F, 1044, 1055}, Row{-0.0101F, 1004, 993},
                        Row{0.0252F, 1049, 1055}, Row{-0.0402F, 984, 984}}) {
    for (int again = 0; again < 2; ++again) {
      const core::Expected<Sticks> sticks = map.to_sticks({.roll_rad = row.command_si, .climb_m_s = row.command_si});
      ASSERT_TRUE(sticks.has_value());
      EXPECT_EQ(static_cast<int>(sticks->roll), row.roll) << row.command_si;
      EXPECT_EQ(static_cast<int>(sticks->throttle), row.throttle) << row.command_si;
    }
  }
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

/// Every number of every axis differs from those of the others.
model::Vehicle four_axes() {
  model::Vehicle vehicle;
  vehicle.roll = {.scale_per_count = 1e-3, .dead_zone_counts = 10.0, .trim_counts = 56.0};
  vehicle.pitch = {.scale_per_count = 2e-3, .dead_zone_counts = 20.0, .trim_counts = -26.0};
  vehicle.climb = {.scale_per_count = 3e-3, .dead_zone_counts = 30.0, .trim_counts = 7.0};
  vehicle.yaw_rate = {.scale_per_count = 4e-3, .dead_zone_counts = 40.0, .trim_counts = -13.0};
  for (model::StickAxis* axis : {&vehicle.roll, &vehicle.pitch, &vehicle.climb, &vehicle.yaw_rate}) {
    axis->dead_zone_shape = model::DeadZoneShape::kJump;
  }
  return vehicle;
}

using Command = ctl::Command<float>;
constexpr std::array kMembers{&Command::roll_rad, &Command::pitch_rad, &Command::climb_m_s, &Command::yaw_rate_rad_s};

std::array<int, 4> counts_of(const Sticks& sticks) {
  return {static_cast<int>(sticks.roll), static_cast<int>(sticks.pitch), static_cast<int>(sticks.throttle),
          static_cast<int>(sticks.yaw)};
}

// Each member alone: one that is not checked would reach the sticks.
TEST(CommandMap, EachNumberThatIsNoneIsRefused) {
  for (const auto member : kMembers) {
    Command command;
    command.*member = std::numeric_limits<float>::quiet_NaN();
    EXPECT_EQ(CommandMap(four_axes()).to_sticks(command).status(), core::Status::kOutOfRange);
  }
  EXPECT_EQ(static_cast<int>(Sticks{}.yaw), 1024) << "the centre, until a command comes";
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
}

// Catches an axis that takes its neutral, its scale or its dead zone from another axis.
TEST(CommandMap, EachAxisHasItsOwnNeutralScaleAndDeadZone) {
  CommandMap map(four_axes());
  EXPECT_EQ(counts_of(map.neutral()), (std::array{1080, 998, 1031, 1011}));
  const Command wanted{.roll_rad = 0.11F, .pitch_rad = -0.44F, .climb_m_s = 0.99F, .yaw_rate_rad_s = 1.76F};
  const core::Expected<Sticks> sticks = map.to_sticks(wanted);
  ASSERT_TRUE(sticks.has_value());
  EXPECT_EQ(counts_of(*sticks), (std::array{1080 + 110, 998 - 220, 1031 + 330, 1011 - 440}));
  const auto beyond_the_edge = [&](int counts) {
    const auto stick = [counts](int edge) { return Stick{static_cast<std::uint16_t>(edge + counts)}; };
    return map.to_command({.roll = stick(1090), .pitch = stick(1018), .throttle = stick(1061), .yaw = stick(1051)});
  };
  for (const auto member : kMembers) {
    EXPECT_NEAR(map.to_command(*sticks).*member, wanted.*member, 1e-6F);
    EXPECT_EQ(beyond_the_edge(0).*member, 0.F);
    EXPECT_GT((member == &Command::yaw_rate_rad_s ? -1.F : 1.F) * beyond_the_edge(1).*member, 0.F);
  }
}

// Catches a remainder that is paid back on another axis, and one that only two of the axes have.
TEST(CommandMap, EachAxisPaysItsOwnRemainderBack) {
  for (std::size_t axis = 0; axis < 4; ++axis) {
    CommandMap map(four_axes());
    const Sticks neutral = map.neutral();
    ctl::Command<float> small;  // two counts: nearer to level than to the edge of any dead zone
    small.*kMembers.at(axis) = 2e-3F * static_cast<float>(axis + 1);
    std::array<int, 4> moved{};
    for (int command = 0; command < 40; ++command) {
      const core::Expected<Sticks> sticks = map.to_sticks(small);
      ASSERT_TRUE(sticks.has_value());
      for (std::size_t stick = 0; stick < 4; ++stick) {
        moved[stick] += static_cast<int>(counts_of(*sticks)[stick] != counts_of(neutral)[stick]);
      }
    }
    for (std::size_t stick = 0; stick < 4; ++stick) {
      // 40 commands of two counts are 80 counts: so many edges of 11, 21, 31 and 41 counts, the last one unfinished.
      constexpr std::array<int, 4> kEdges{7, 3, 2, 1};
      EXPECT_NEAR(moved[stick], stick == axis ? kEdges.at(stick) : 0, stick == axis ? 1 : 0) << axis << " " << stick;
    }
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
  far.roll_rad = -5.F;
  ASSERT_TRUE(map.to_sticks(far).has_value());
  EXPECT_EQ(static_cast<int>(map.to_sticks(none)->roll), 1024 - 21);
  far.roll_rad = 5.F;
  ASSERT_TRUE(map.to_sticks(far).has_value());
  map.reset();
  EXPECT_EQ(static_cast<int>(map.to_sticks(none)->roll), 1024) << "a reset forgets it";
}

// Catches a vehicle that is constructed by hand and makes a stick of a quotient by zero.
TEST(CommandMapDeathTest, ANumberThatCannotDivideIsRefused) {
  const auto with = [](auto member, double value) {
    model::Vehicle vehicle = four_axes();
    vehicle.climb.*member = value;
    return vehicle;
  };
  for (const auto member : {&model::StickAxis::gain_asymmetry, &model::StickAxis::stick_exponent}) {
    const CommandMap small(with(member, 0.3));
    EXPECT_EQ(static_cast<int>(small.neutral().throttle), 1031) << "any number above zero divides";
  }
  const CommandMap none(with(&model::StickAxis::dead_zone_counts, 0.0));
  EXPECT_EQ(static_cast<int>(none.neutral().throttle), 1031);
  EXPECT_DEATH(CommandMap{with(&model::StickAxis::dead_zone_counts, -1.0)}, "");
  EXPECT_DEATH(CommandMap{with(&model::StickAxis::stick_exponent, 0.0)}, "");
  EXPECT_DEATH(CommandMap{with(&model::StickAxis::gain_asymmetry, 0.0)}, "");
  EXPECT_DEATH(CommandMap{with(&model::StickAxis::trim_counts, std::numeric_limits<double>::infinity())}, "");
}

}  // namespace
}  // namespace m100::vrc
