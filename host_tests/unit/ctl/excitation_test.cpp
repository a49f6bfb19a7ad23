// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/ctl/excitation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

namespace m100::ctl {
namespace {

using State = Excitation<double>::State;
using Abort = Excitation<double>::Abort;

core::TimePoint at(double seconds) { return core::TimePoint(core::Duration(std::llround(seconds * 1e6))); }

/// An excitation of two pieces of 10 samples each: roll, then yaw.
struct ExcitationTest : ::testing::Test {
  std::vector<std::int16_t> counts = std::vector<std::int16_t>(20);  // 100 to 119
  std::vector<ExcitationPiece> pieces{{.axis = ExcitedStick::kRoll, .begin = 0, .count = 10},
                                      {.axis = ExcitedStick::kYaw, .begin = 10, .count = 10}};
  static constexpr ExcitationLimits kLimits{.distance = 4.0, .braking = 2.0, .speed = 3.0, .tilt_rad = 0.4};
  Excitation<double> excitation{
      ExcitationPlan{.counts = counts, .pieces = pieces, .limits = {kLimits, ExcitationLimits{}, {}, kLimits}}};
  est::Estimate<double> estimate;
  ref::Window<double> reference;
  double now_s = 1.0;

  ExcitationTest() {
    std::iota(counts.begin(), counts.end(), std::int16_t{100});
    excitation.start(at(now_s));
  }
  /// Runs ticks of 10 ms.
  void fly(double seconds, bool may = true, bool brakes = false) {
    for (int tick = 0; tick < static_cast<int>(seconds * 100.0 + 0.5); ++tick) {
      now_s += 0.01;
      excitation.update(estimate, reference, may, brakes, at(now_s));
    }
  }
  void begin_piece() {
    fly(0.79);
    ASSERT_EQ(excitation.state(), State::kReturning);
    fly(0.01);
    ASSERT_EQ(excitation.state(), State::kMoving);
  }
};

TEST_F(ExcitationTest, MovesOneStickAfterTheOtherAndThenNone) {
  EXPECT_EQ(excitation.counts(), 0) << "the law returns first";
  begin_piece();
  EXPECT_EQ(excitation.axis(), ExcitedStick::kRoll);
  EXPECT_EQ(excitation.counts(), 100);
  fly(0.08);  // four samples of 20 ms, of ten
  EXPECT_EQ(excitation.counts(), 104);
  EXPECT_EQ(excitation.sample(), 4U);
  fly(0.12);
  EXPECT_EQ(excitation.state(), State::kReturning);
  begin_piece();
  EXPECT_EQ(excitation.axis(), ExcitedStick::kYaw);
  EXPECT_EQ(excitation.counts(), 110);
  fly(0.3);
  EXPECT_EQ(excitation.state(), State::kOver);
  EXPECT_EQ(excitation.counts(), 0);
  EXPECT_EQ(excitation.piece(), 2U);
  excitation.start(at(now_s));
  begin_piece();
  EXPECT_EQ(excitation.piece(), 0U);
}

// Catches sticks that move about an outdated balance point: wind and a wrong trim then carry the aircraft away.
TEST_F(ExcitationTest, SwingsAboutTheSticksThatHeldThePlace) {
  estimate.x.velocity_m_s = 1.0;
  for (int tick = 0; tick < 100; ++tick) {  // counts observed while it moves must be ignored
    excitation.rest_at({.roll_counts = -500.0, .pitch_counts = -500.0});
    fly(0.01);
  }
  estimate.x.velocity_m_s = 0.0;
  EXPECT_EQ(excitation.holding_counts(), 0) << "the law flies";
  for (int tick = 0; excitation.returns() && tick < 1000; ++tick) {
    excitation.rest_at({.roll_counts = tick % 2 == 0 ? 24.3 : 36.3, .pitch_counts = 70.0});
    fly(0.01);
  }
  EXPECT_EQ(excitation.axis(), ExcitedStick::kRoll);
  EXPECT_NEAR(excitation.holding_counts(), 30, 1);
  EXPECT_EQ(excitation.counts(), 100) << "the plan's";
  fly(0.2);
  begin_piece();
  EXPECT_EQ(excitation.axis(), ExcitedStick::kYaw);
  EXPECT_EQ(excitation.holding_counts(), 0) << "a heading is held by a resting stick";
}

// Both sides of each bound: a piece begins within it, and never beyond it.
TEST_F(ExcitationTest, BeginsOnlyAtRestAtItsPlaceInEachDirection) {
  const std::pair<double*, double> bounds[] = {{&estimate.x.position_m, 0.3},    {&estimate.y.position_m, 0.3},
                                               {&estimate.height_m, 0.3},        {&estimate.x.velocity_m_s, 0.15},
                                               {&estimate.y.velocity_m_s, 0.15}, {&estimate.climb_m_s, 0.15},
                                               {&estimate.yaw_rad, 0.15}};
  for (const auto& [value, bound] : bounds) {
    for (const double share : {1.05, -1.05, 0.95, -0.95}) {
      excitation.start(at(now_s));
      *value = share * bound;
      fly(0.85);
      EXPECT_EQ(excitation.moves(), std::abs(share) < 1.0) << value - &estimate.x.position_m << ": " << share;
    }
    *value = 0.0;
  }
}

// Each stick has its own axis of the body, and its own sign.
TEST_F(ExcitationTest, MeasuresDistanceAndSpeedAlongTheStick) {
  estimate.x = {.position_m = 1.0, .velocity_m_s = 0.5};
  estimate.y = {.position_m = -0.4, .velocity_m_s = 0.3};
  estimate.height_m = 2.0;
  estimate.climb_m_s = 0.7;
  estimate.yaw_rad = 0.6;
  estimate.yaw_rate_rad_s = 0.9;
  reference.x[0].position_m = 0.2;
  reference.y[0].position_m = 0.1;
  reference.height.position_m = 1.5;
  reference.yaw_rad = 0.4;
  const double c = std::cos(0.6), s = std::sin(0.6);
  constexpr int kHolding[] = {200, -71, 0, 0};  // at most a tilt of 10 degrees
  const double distances[] = {s * 0.8 + c * 0.5, c * 0.8 - s * 0.5, 0.5, -0.2};
  const double speeds[] = {s * 0.5 - c * 0.3, c * 0.5 + s * 0.3, 0.7, -0.9};
  for (std::size_t stick = 0; stick < kStickAxes; ++stick) {
    pieces.assign(1, {.axis = static_cast<ExcitedStick>(stick), .begin = 0, .count = 10});
    Excitation<double> one{ExcitationPlan{.counts = counts, .pieces = pieces}};
    one.start(at(1.0));
    one.rest_at({.roll_counts = 250.0, .pitch_counts = -70.6});
    one.update(estimate, reference, true, false, at(1.01));
    EXPECT_NEAR(one.distance(), distances[stick], 1e-12) << stick;
    EXPECT_NEAR(one.speed(), speeds[stick], 1e-12) << stick;
    one.update({}, {}, true, false, at(1.02));
    one.update({}, {}, true, false, at(1.85));
    ASSERT_TRUE(one.moves());
    EXPECT_EQ(one.holding_counts(), kHolding[stick]);
  }
}

// The time-out counts from the beginning of the return, and its last moment is still allowed.
TEST_F(ExcitationTest, WaitsForAsLongAsItSays) {
  const core::TimePoint last = at(now_s) + std::chrono::seconds(30);
  estimate.x.velocity_m_s = 0.3;
  excitation.update(estimate, reference, true, false, last);
  EXPECT_EQ(excitation.state(), State::kReturning);
  excitation.update(estimate, reference, true, false, last + core::Duration(1));
  EXPECT_EQ(excitation.abort(), Abort::kNotAtRest);
  EXPECT_EQ(excitation.ended() - excitation.began(), std::chrono::seconds(30) + core::Duration(1));
}

struct LimitCase {
  const char* name;
  double left_m, velocity_left_m_s, tilt_rad, yaw_rad;
  bool may, brakes;
  Abort expected;
};
class Limit : public ExcitationTest, public ::testing::WithParamInterface<LimitCase> {};
// Stick right moves the aircraft to -y; distances and speeds are measured along the moved stick's axis.
INSTANTIATE_TEST_SUITE_P(
    Of, Limit,
    ::testing::Values(LimitCase{"NoneAtRest", 0, 0, 0, 0, true, false, Abort::kNone},
                      LimitCase{"DistanceAlone", 4.1, 0, 0, 0, true, false, Abort::kDistance},
                      LimitCase{"NoneWithRoomToBrake", 2.9, 2, 0, 0, true, false, Abort::kNone},
                      LimitCase{"DistanceWithTheWayToBrake", 3.1, 2, 0, 0, true, false, Abort::kDistance},
                      LimitCase{"NoneWhereItComesBack", 3.1, -2, 0, 0, true, false, Abort::kNone},
                      LimitCase{"DistanceToTheOtherSide", -3.1, -2, 0, 0, true, false, Abort::kDistance},
                      LimitCase{"NoneAcrossTheStick", 3.5, 2, 0, 1.5707963, true, false, Abort::kNone},
                      LimitCase{"NoneBelowSpeedAndTilt", 0, 2.9, 0.39, 0, true, false, Abort::kNone},
                      LimitCase{"Speed", 0, 3.1, 0, 0, true, false, Abort::kSpeed},
                      LimitCase{"Tilt", 0, 0, 0.41, 0, true, false, Abort::kTilt},
                      LimitCase{"Fence", 0, 0, 0, 0, true, true, Abort::kFence},
                      LimitCase{"Failsafe", 0, 0, 0, 0, false, true, Abort::kFailsafe}),
    [](const auto& tested) { return std::string(tested.param.name); });

TEST_P(Limit, EndsTheExcitationForGood) {
  begin_piece();
  fly(0.04);
  estimate.y.position_m = GetParam().left_m;
  estimate.y.velocity_m_s = GetParam().velocity_left_m_s;
  estimate.x.tilt_rad = 0.8 * GetParam().tilt_rad;
  estimate.y.tilt_rad = 0.6 * GetParam().tilt_rad;
  estimate.yaw_rad = reference.yaw_rad = GetParam().yaw_rad;
  fly(0.02, GetParam().may, GetParam().brakes);
  EXPECT_EQ(excitation.abort(), GetParam().expected) << Excitation<double>::name(excitation.abort());
  EXPECT_EQ(excitation.state(), GetParam().expected == Abort::kNone ? State::kMoving : State::kAborted);
  if (GetParam().expected != Abort::kNone) {
    EXPECT_EQ(excitation.counts(), 0);
    estimate = {};
    fly(5.0);
    EXPECT_EQ(excitation.state(), State::kAborted) << "only the operator's word begins anew";
    excitation.start(at(now_s));
    begin_piece();
    EXPECT_EQ(excitation.abort(), Abort::kNone);
    EXPECT_EQ(excitation.counts(), 100);
  }
}

TEST(WithoutAPlan, ThereIsNothingToFly) {
  Excitation<float> none{ExcitationPlan{}};
  none.start(at(1.0));
  none.update({}, {}, true, false, at(2.0));
  EXPECT_EQ(none.state(), Excitation<float>::State::kIdle);
  EXPECT_EQ(none.counts(), 0);
}

// Catches two reasons with the same name: a log would not tell why an excitation ended.
TEST(AbortName, IsAnotherWordForEach) {
  std::set<std::string_view> words;
  for (const Abort abort : {Abort::kNone, Abort::kFailsafe, Abort::kFence, Abort::kDistance, Abort::kTilt,
                            Abort::kSpeed, Abort::kNotAtRest}) {
    EXPECT_TRUE(words.insert(Excitation<double>::name(abort)).second) << Excitation<double>::name(abort);
  }
  EXPECT_EQ(Excitation<double>::name(static_cast<Abort>(99)), "none") << "a byte of a damaged log";
}

}  // namespace
}  // namespace m100::ctl
