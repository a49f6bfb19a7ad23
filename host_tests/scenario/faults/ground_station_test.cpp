// SPDX-License-Identifier: BSD-3-Clause
// Goals and orders of a room with the whole flight controller and the operator's part of a flight.
#include "firmware/companion/ground_station/ground_station_commands.h"

#include <gtest/gtest.h>

#include <cmath>

#include "hal/mock/manual_clock.h"
#include "hal/mock/uart_pair.h"
#include "host_tests/scenario/faults/fault_bench.h"
#include "host_tests/scenario/faults/message_recorder.h"

namespace m100::scenario {
namespace {

constexpr mavlink::Address kStation{.system = 255, .component = 190};
constexpr std::uint16_t kOnlyPosition = 0b110111111000;

class GroundStationTest : public ::testing::Test {
 protected:
  GroundStationTest()
      : commands_(companion::GoalSettings{}, app::kDefaultFlight.fence, bench_.course(), line_, nullptr, heard_),
        sequencer_({.course_start_w_m = bench_.place(), .max_start_distance_m = 1.5}, app::kDefaultFlight,
                   bench_.controller(), bench_.course(), heard_) {}

  template <typename Message>
  void say(const Message& message) {
    const mavlink::Frame frame = mavlink::encode(message, kStation, sequence_++);
    EXPECT_EQ(pair_.b().write(frame.bytes()).value_or(0), frame.bytes().size());
    std::vector<std::byte> got(frame.bytes().size());
    EXPECT_EQ(line_.read(got).value_or(0), got.size());
  }
  void order(std::uint16_t command, float param1) {
    say(mavlink::CommandLong{.param1 = param1, .command = command, .target_system = 1});
  }
  /// Sends a goal in the room's frame: north, east; at the height of the start.
  void goal(float x, float y) {
    say(mavlink::SetPositionTargetLocalNed{.x = x,
                                           .y = y,
                                           .z = static_cast<float>(-bench_.place().z()),
                                           .type_mask = kOnlyPosition,
                                           .target_system = 1,
                                           .coordinate_frame = 1});
  }
  void tick() {
    bench_.tick();
    const core::TimePoint now = bench_.world().now();
    companion::OperatorInput input = commands_.tick(now, bench_.controller(), sequencer_.status(now));
    input.goal_led = commands_.has_goal();
    (void)sequencer_.tick(now, input);
  }
  void pass(core::Duration time) {
    for (const core::TimePoint end = bench_.world().now() + time; bench_.world().now() < end;) {
      tick();
    }
  }
  template <typename Condition>
  bool until(const Condition& condition, core::Duration at_most) {
    for (const core::TimePoint end = bench_.world().now() + at_most; bench_.world().now() < end && !condition();) {
      tick();
    }
    return condition();
  }
  bool engage() {
    order(companion::kGuidedEnable, 1.F);
    return until([&] { return bench_.failsafe_state() == FailsafeState::kNominal; }, seconds(10));
  }
  bool get_ready_and_engage() {
    const auto ready = [&] { return bench_.controller().link().authority().stage == safety::AuthorityStage::kReady; };
    if (!until(ready, seconds(10))) {
      return false;
    }
    pass(seconds(1));
    return engage();
  }
  bool release() {
    order(companion::kGuidedEnable, 0.F);
    return until([&] { return sequencer_.status(bench_.world().now()).waits; }, seconds(3));
  }
  const core::Vector<double, 3>& at() { return bench_.world().vehicle().state().position_w_m; }
  double off_m() {
    const ref::Window<double>& to = bench_.controller().reference();
    return std::hypot(to.x[0].position_m - at().x(), to.y[0].position_m - at().y());
  }

  FaultBench bench_;
  MessageRecorder heard_;
  hal::ManualClock clock_;
  hal::UartPair pair_{clock_, 0};
  companion::GroundStationTap line_{pair_.a()};
  companion::GroundStationCommands commands_;
  companion::FlightSequencer sequencer_;
  std::uint8_t sequence_ = 0;
};

// Catches a flight that is refused at the place where goals led it, or that flies back from there to its first
// beginning; and one whose first tick still follows the path to the last goal.
TEST_F(GroundStationTest, AFlightThatGoalsHaveLedBeginsAgainWhereTheAircraftIs) {
  RecordProperty("promise", "R16");
  ASSERT_TRUE(get_ready_and_engage()) << heard_.all();
  goal(3.F, 0.F);
  pass(seconds(8));
  ASSERT_NEAR(at().x(), 3.0, 0.2) << heard_.all();
  ASSERT_TRUE(release()) << heard_.all();
  sim::StickInput sticks;
  sticks.pitch_vrc -= 80.0;
  bench_.world().autopilot().set_pilot_sticks(sticks);
  ASSERT_TRUE(until([&] { return at().x() < 2.0; }, seconds(8)));
  ASSERT_TRUE(engage()) << heard_.all();
  EXPECT_LT(off_m(), 0.1) << "in the first tick of the flight";
  const double here_m = at().x();
  pass(seconds(5));
  EXPECT_EQ(bench_.failsafe_state(), FailsafeState::kNominal);
  EXPECT_NEAR(at().x(), here_m, 1.5) << "tolerance: the distance to stop";
}

TEST_F(GroundStationTest, AnOrderToFlyWhileControlGoesBackIsRefused) {
  ASSERT_TRUE(get_ready_and_engage()) << heard_.all();
  order(companion::kGuidedEnable, 0.F);
  pass(milliseconds(50));
  ASSERT_TRUE(sequencer_.status(bench_.world().now()).is_releasing);
  order(companion::kGuidedEnable, 1.F);
  pass(milliseconds(50));
  EXPECT_TRUE(heard_.has("engage, refused: control is being given back")) << heard_.all();
  EXPECT_TRUE(until([&] { return sequencer_.status(bench_.world().now()).waits; }, seconds(3)));
}

// Catches an order to hold that is answered but not flown.
TEST_F(GroundStationTest, AnOrderToHoldStopsOnTheWayToAGoal) {
  ASSERT_TRUE(get_ready_and_engage()) << heard_.all();
  goal(4.F, 0.F);
  ASSERT_TRUE(until([&] { return at().x() > 1.0; }, seconds(5))) << heard_.all();
  order(companion::kPauseContinue, 1.F);
  order(companion::kPauseContinue, 0.F);
  pass(seconds(8));
  EXPECT_TRUE(heard_.has("command 193, refused: this program does not support it")) << heard_.all();
  EXPECT_TRUE(heard_.has("ground station: hold")) << heard_.all();
  EXPECT_FALSE(heard_.has("hold, refused")) << heard_.all();
  EXPECT_GT(at().x(), 1.0);
  EXPECT_LT(at().x(), 3.2) << "from 1.0 m the reference leads by at most 0.6 m, and stops within 1.4 m";
  EXPECT_LT(off_m(), 0.2);
}

}  // namespace
}  // namespace m100::scenario
