// SPDX-License-Identifier: BSD-3-Clause
// The operator's part of m100 fly with the whole flight controller. Who has control is judged at the autopilot.
#include "firmware/companion/fly/flight_sequencer.h"

#include <gtest/gtest.h>

#include "host_tests/scenario/faults/flight_sequencer_fixture.h"

namespace m100::scenario {
namespace {

INSTANTIATE_TEST_SUITE_P(Faults, FlightSequencerTest,
                         ::testing::Values(link::Channel::kVirtualRc, link::Channel::kMovement));

// Catches a program that ends and keeps control: it sends one release, gets the answer "again", and exits.
TEST_P(FlightSequencerTest, AfterTheFailsafesReleaseTheTransmitterHasItAndTheProgramStays) {
  RecordProperty("promise", "R15");
  begin({.take_control = true, .hold_s = 1000.0});
  ASSERT_TRUE(fly_for(seconds(3))) << heard_.all();
  bench_->world().pose_source().set_faults({.silent = true});
  ASSERT_TRUE(until([&] { return bench_->failsafe_state() == FailsafeState::kRelease; }, seconds(3)));
  const auto taken = until([&] { return is_pilots(); }, seconds(2));
  ASSERT_TRUE(taken.has_value()) << heard_.all();
  EXPECT_LE(*taken, seconds(1));
  ASSERT_FALSE(until([] { return false; }, seconds(2)) || ended_) << heard_.all();
  EXPECT_TRUE(heard_.has("pose old: 0.0")) << heard_.all();
  EXPECT_TRUE(heard_.has("the transmitter has the aircraft")) << heard_.all();
  EXPECT_FALSE(sequencer_->given_back()) << "the operator has not stopped it";
  bench_->world().pose_source().set_faults({});
  (void)until([] { return false; }, seconds(1));
  EXPECT_TRUE(is_pilots()) << "the program flies without an order";
  input_.toggle_control = true;
  EXPECT_TRUE(fly_for(seconds(1))) << "a new order of the operator has no effect\n" << heard_.all();
}

// Catches a program that was started on the ground or at another place, and flies back there on the order to fly.
TEST_P(FlightSequencerTest, FarFromTheCoursesBeginningControlIsNotTakenAndItSaysWhy) {
  for (const bool once : {false, true}) {
    ended_ = false;
    begin({.take_control = true,
           .hold_s = 1000.0,
           .once = once,
           .course_start_w_m = bench_start() + core::Vector<double, 3>{2.0, 0.0, 0.0},
           .max_start_distance_m = 1.5});
    (void)until([] { return false; }, seconds(10));
    EXPECT_TRUE(is_pilots());
    EXPECT_FALSE(sequencer_->flew());
    EXPECT_TRUE(heard_.has("fly there, or start m100 again here")) << heard_.all();
    EXPECT_EQ(ended_, once) << "only a script (--once) ends";
  }
}

// Catches a script that waits for ever for a dead source of poses.
TEST_P(FlightSequencerTest, AScriptWithoutAPoseEndsAfterTwentySecondsAndSaysWhy) {
  begin({.take_control = true, .hold_s = 1000.0, .once = true});
  bench_->world().pose_source().set_faults({.silent = true});
  const core::TimePoint from = bench_->world().now();
  (void)until([] { return false; }, seconds(40));
  ASSERT_TRUE(ended_) << heard_.all();
  const double after_s = core::seconds<double>(bench_->world().now() - from);
  EXPECT_GT(after_s, 20.0);
  EXPECT_LT(after_s, 28.0) << "20 s, plus some seconds of start-up";
  EXPECT_TRUE(heard_.has("control is not asked for yet")) << heard_.all();
  EXPECT_EQ(bench_->noted().obtain_requests, 0U);
}

// Without the backup process nobody would give control back after a death of the program. Then control is not taken,
// and a request in progress is given back.
TEST_P(FlightSequencerTest, WithoutTheSecondProcessControlIsNotAskedFor) {
  RecordProperty("promise", "R15");
  begin({.take_control = true, .hold_s = 1000.0});
  input_.backed_up = false;
  (void)until([] { return false; }, seconds(12));
  EXPECT_EQ(bench_->noted().obtain_requests, 0U);
  EXPECT_TRUE(heard_.has("nobody would give it back if this program died")) << heard_.all();
  input_.backed_up = true;
  input_.toggle_control = true;
  ASSERT_TRUE(until([&] { return bench_->noted().obtain_requests > 0U; }, seconds(5))) << heard_.all();
  input_.backed_up = false;
  (void)until([] { return false; }, seconds(5));
  EXPECT_TRUE(is_pilots());
  EXPECT_FALSE(sequencer_->flew());
}

/// A fence whose limit along x is `metres` beyond the aircraft's place.
core::Fence fence_beyond(const core::Vector<double, 3>& place, double metres) {
  core::Fence fence;
  fence.side[core::Fence::kX] = {.low_m = place.x() - 50.0, .high_m = place.x() + metres};
  return fence;
}

// Catches a program that asks for control outside the fence, where it may not command: the pilot would lose the sticks.
TEST_P(FlightSequencerTest, OutsideTheFenceControlIsNotAskedForAndItSaysWhy) {
  RecordProperty("promise", "R16");
  for (const double begins_m : {0.0, -4.0}) {  // within reach of the course's beginning, and beyond
    begin(
        {.course_start_w_m = bench_start() + core::Vector<double, 3>{begins_m, 0.0, 0.0}, .max_start_distance_m = 1.5},
        fence_beyond(bench_start(), -2.0));
    (void)until([&] { return bench_->controller().link().authority().stage == safety::AuthorityStage::kReady; },
                seconds(10));
    (void)until([] { return false; }, seconds(1));
    input_.toggle_control = true;
    (void)until([] { return false; }, seconds(3));
    EXPECT_TRUE(is_pilots());
    EXPECT_FALSE(sequencer_->flew());
    EXPECT_EQ(bench_->noted().obtain_requests, 0U);
    EXPECT_TRUE(
        heard_.has("control is not taken; the aircraft is 2.00 m outside its fence: bring the aircraft inside, or "
                   "take a larger fence"))
        << heard_.all();
    EXPECT_FALSE(heard_.has("check the source of pose")) << heard_.all();
  }
}

/// A flight that is ordered 0.3 m before a limit of the place, at 3 m/s.
struct Leaving {
  const char* name;
  double fence_m;               ///< from the start
  double max_start_distance_m;  ///< from the start
  bool pose_is_lost;            ///< from the order to fly until control is granted
  const char* words;
};

// Catches a check of the place that is not made outside the fence, or not after control is granted: the failsafe then
// goes to nominal as soon as it can, and the law flies the whole distance at once.
TEST_P(FlightSequencerTest, WhoLeavesWhileControlIsAskedForIsNotFlown) {
  RecordProperty("promise", "R16");
  for (const Leaving& way : {Leaving{"fence", 5.0, 1e9, false, "m outside its fence: bring the aircraft inside"},
                             Leaving{"reach", 1e3, 5.0, false, "the course begins at"},
                             Leaving{"fence, unseen", 5.0, 1e9, true, "m outside its fence: bring the aircraft inside"},
                             Leaving{"reach, unseen", 1e3, 5.0, true, "the course begins at"}}) {
    SCOPED_TRACE(way.name);
    const core::Vector<double, 3> start = bench_start();
    begin({.course_start_w_m = start, .max_start_distance_m = way.max_start_distance_m},
          fence_beyond(start, way.fence_m));
    (void)until([&] { return bench_->controller().link().authority().stage == safety::AuthorityStage::kReady; },
                seconds(10));
    (void)until([] { return false; }, seconds(1));
    sim::StickInput sticks;
    sticks.pitch_vrc += 150.0;
    bench_->world().autopilot().set_pilot_sticks(sticks);
    const auto gone_m = [&] { return (bench_->world().vehicle().state().position_w_m - start).norm(); };
    ASSERT_TRUE(until([&] { return gone_m() > 4.7; }, seconds(8))) << heard_.all();
    input_.toggle_control = true;
    ASSERT_TRUE(tick());
    const auto in_control = [&] { return bench_->controller().link().authority().in_control; };
    ASSERT_FALSE(in_control()) << heard_.all();
    if (way.pose_is_lost) {
      bench_->world().pose_source().set_faults({.silent = true});
      ASSERT_TRUE(until(in_control, seconds(5))) << heard_.all();
      bench_->world().pose_source().set_faults({});
    }
    (void)until([] { return false; }, seconds(3));
    EXPECT_TRUE(is_pilots()) << heard_.all();
    EXPECT_EQ(bench_->controller().supervisor().stats().steps, 0U) << heard_.all();
    EXPECT_TRUE(heard_.has(way.words)) << heard_.all();
    heard_.lines.clear();
  }
}

TEST_P(FlightSequencerTest, AScriptsFlightEndsAfterTheReleaseAndNotBefore) {
  RecordProperty("promise", "R15");
  begin({.take_control = true, .hold_s = 1000.0, .once = true});
  ASSERT_TRUE(fly_for(seconds(3)));
  bench_->world().pose_source().set_faults({.silent = true});
  (void)until([] { return false; }, seconds(5));
  EXPECT_TRUE(ended_);
  EXPECT_TRUE(is_pilots());
  EXPECT_FALSE(sequencer_->given_back());
}

// Catches a script that waits for ever for an autopilot that is off, or without telemetry.
TEST_P(FlightSequencerTest, AScriptEndsWhereTheAutopilotDoesNotBecomeReady) {
  begin({.take_control = true, .hold_s = 1.0, .once = true});
  bench_->world().autopilot_line().set_plugged(false);
  const auto ended = until([&] { return ended_; }, seconds(30));
  ASSERT_TRUE(ended_) << heard_.all();
  EXPECT_GE(ended.value_or(seconds(30)), seconds(20));
  EXPECT_FALSE(sequencer_->flew());
  EXPECT_TRUE(heard_.has("control could not be asked for within 20 s: ")) << heard_.all();
}

// Catches a message that blames the source of poses while telemetry is missing.
TEST_P(FlightSequencerTest, BeforeTelemetryAWordWaitsForStartUp) {
  begin({.course_start_w_m = bench_start(), .max_start_distance_m = 1.5});
  ASSERT_TRUE(tick());
  ASSERT_EQ(bench_->controller().link().health().packages, 0U);
  input_.toggle_control = true;
  (void)until([] { return false; }, milliseconds(100));
  EXPECT_FALSE(heard_.has("pose old")) << heard_.all();
  EXPECT_TRUE(fly_for(seconds(1))) << "the order must stay valid for 20 s\n" << heard_.all();
}

TEST_P(FlightSequencerTest, TheOperatorsStopTheWordAndTheEndOfTheHoldEndInASecond) {
  RecordProperty("promise", "R15");
  for (const int way : {0, 1, 2}) {
    SCOPED_TRACE(way);
    ended_ = false;
    input_ = {};
    begin({.take_control = true, .hold_s = way == 2 ? 2.0 : 1000.0});
    ASSERT_TRUE(until([&] { return bench_->world().autopilot().client_in_control(); }, seconds(20)));
    (void)until([] { return false; }, seconds(2));
    input_.stops = way == 0 ? 1 : 0;
    input_.toggle_control = way == 1;
    const auto taken = until([&] { return is_pilots(); }, seconds(3));
    ASSERT_TRUE(taken.has_value()) << heard_.all();
    EXPECT_LE(*taken, seconds(1));
    EXPECT_FALSE(ended_) << "telemetry has not reported it yet";
    (void)until([] { return false; }, milliseconds(100));
    EXPECT_TRUE(ended_);
    EXPECT_TRUE(sequencer_->given_back());
  }
}

/// A wind that carries a level aircraft away.
sim::Plant in_wind() {
  sim::Plant plant = sim::measured_plant();
  plant.air.wind_m_s = {-1.5, 0.0, 0.0};
  plant.air.linear_drag_per_s = 0.3;
  return plant;
}

// Catches a flight that begins after a hover in place of a landing, and goes to where that hover was.
TEST_P(FlightSequencerTest, AfterAHoverInPlaceOfALandingTheNextFlightBeginsWhereTheAircraftIs) {
  begin({.take_control = true,
         .hold_s = 3.0,
         .land = true,
         .course_start_w_m = bench_start(),
         .max_start_distance_m = 6.0},
        {}, in_wind());
  ASSERT_TRUE(until([&] { return heard_.has("land by hand"); }, seconds(30))) << heard_.all();
  ASSERT_TRUE(until([&] { return is_pilots(); }, seconds(12))) << heard_.all();
  const auto place_w_m = [&] { return bench_->world().vehicle().state().position_w_m; };
  const core::Vector<double, 3> left_w_m = place_w_m();
  ASSERT_TRUE(until([&] { return (place_w_m() - left_w_m).norm() > 6.5; }, seconds(10)));
  input_.toggle_control = true;
  ASSERT_TRUE(fly_for(seconds(5))) << heard_.all();
  EXPECT_GT((place_w_m() - left_w_m).norm(), 6.0) << heard_.all();
}

// Catches a hover that goes on, or ends as an error of the attitude, while the autopilot lands by itself.
TEST_P(FlightSequencerTest, ALandingThatNobodyOrderedEndsTheHoverInPlaceOfALanding) {
  begin({.take_control = true, .hold_s = 3.0, .land = true}, {}, in_wind());
  ASSERT_TRUE(until([&] { return heard_.has("land by hand"); }, seconds(30))) << heard_.all();
  bench_->world().autopilot().set_telemetry_fault(
      [](protocol::Telemetry& sent) { sent.flight_status = protocol::FlightStatus::kLanding; });
  const auto taken = until([&] { return is_pilots(); }, seconds(12));
  ASSERT_TRUE(taken.has_value()) << heard_.all();
  EXPECT_LE(*taken, milliseconds(1400)) << heard_.all();
  EXPECT_TRUE(heard_.has("the autopilot lands by itself")) << heard_.all();
}

// At a low battery the autopilot lands by itself and ignores the sticks. Catches a program that says nothing, and flies
// its course until a check takes the descent for a false attitude; and one that ends for a status of a moment.
TEST_P(FlightSequencerTest, ALandingThatNobodyOrderedIsSaidAndEndsTheCourse) {
  RecordProperty("promise", "R15");
  begin({.take_control = true, .hold_s = 1000.0});
  ASSERT_TRUE(fly_for(seconds(3))) << heard_.all();
  const auto shows = [&](protocol::FlightStatus status) {
    bench_->world().autopilot().set_telemetry_fault(
        [status](protocol::Telemetry& sent) { sent.flight_status = status; });
  };
  shows(protocol::FlightStatus::kLanding);
  (void)until([] { return false; }, milliseconds(400));
  shows(protocol::FlightStatus::kInAir);
  ASSERT_TRUE(fly_for(seconds(2))) << heard_.all();
  EXPECT_FALSE(heard_.has("lands by itself")) << heard_.all();
  shows(protocol::FlightStatus::kLanding);
  const auto taken = until([&] { return is_pilots(); }, seconds(3));
  ASSERT_TRUE(taken.has_value()) << heard_.all();
  EXPECT_LE(*taken, milliseconds(1400)) << "0.5 s of the status, two items at 10 Hz, 0.5 s of the release";
  EXPECT_TRUE(heard_.has("the autopilot lands by itself")) << heard_.all();
  EXPECT_FALSE(ended_) << "the operator may order the next flight";
  EXPECT_FALSE(sequencer_->given_back()) << "the operator has not ended it";
}

// Catches a flight that ends, and blames the pose, because the autopilot's compass is disturbed; and one that says
// nothing of it, or says it again and again.
TEST_P(FlightSequencerTest, AHeadingOfTheAutopilotThatJumpsAloneIsSaidOnceAndTheFlightGoesOn) {
  begin({.take_control = true, .hold_s = 1000.0});
  ASSERT_TRUE(fly_for(seconds(3))) << heard_.all();
  bench_->forget_worst();
  bench_->world().autopilot().start_sensor_fault(*sim::find_sensor_fault("yaw"), 60.0);
  EXPECT_TRUE(fly_for(seconds(10))) << heard_.all();
  EXPECT_LT(bench_->farthest_m(), 0.2) << "as before the jump";
  const auto says = [](const std::string& line) { return line.find("the autopilot's heading jumped by 60") == 0; };
  EXPECT_EQ(std::count_if(heard_.lines.begin(), heard_.lines.end(), says), 1) << heard_.all();
}

// Loop closures of a visual source, which it announces by its reset_counter. Catches a flight that ends and blames the
// pose, an aircraft that flies the jump, and a fence that walks with the source's world.
TEST_P(FlightSequencerTest, AnAnnouncedJumpOfTheSourceEndsNoFlightAndMovesNothing) {
  const core::Vector<double, 3> start = bench_start();
  core::Fence fence;
  fence.side[core::Fence::kX] = {.low_m = start.x() - 3.0, .high_m = start.x() + 3.0};
  fence.side[core::Fence::kY] = {.low_m = start.y() - 3.0, .high_m = start.y() + 3.0};
  begin({.take_control = true, .hold_s = 1000.0}, fence);
  ASSERT_TRUE(fly_for(seconds(4))) << heard_.all();
  bench_->forget_worst();
  for (int i = 0; i < 10; ++i) {
    bench_->pose_line().jump({i == 0 ? 0.5 : 0.02, i == 1 ? -1.0 : 0.0, 0.0}, i == 2 ? 1.0 : 0.0, true);
    ASSERT_TRUE(fly_for(seconds(3))) << heard_.all();
    EXPECT_EQ(heard_.has("ten jumps of the pose source in a minute"), i == 9) << heard_.all();
  }
  EXPECT_LT(bench_->farthest_m(), 0.2) << "as in a hover without jumps";
  EXPECT_TRUE(heard_.has("announced a jump of its world (reset_counter) by 0.5")) << heard_.all();
  EXPECT_TRUE(heard_.has(" m and 57 degrees")) << heard_.all();
  bench_->pose_line().jump({4.0, 0.0, 0.0}, 0.0, true);  // by the source, the aircraft is now outside its fence
  ASSERT_TRUE(until([&] { return is_pilots(); }, seconds(6))) << heard_.all();
  EXPECT_TRUE(heard_.has("m outside its fence")) << heard_.all();
}

// The same jump without an announcement is a fault of the pose, as before.
TEST_P(FlightSequencerTest, AJumpThatIsNotAnnouncedIsRefused) {
  begin({.take_control = true, .hold_s = 1000.0});
  ASSERT_TRUE(fly_for(seconds(4))) << heard_.all();
  bench_->pose_line().jump({0.5, 0.0, 0.0}, 0.0, false);
  ASSERT_TRUE(until([&] { return is_pilots(); }, seconds(6))) << heard_.all();
  EXPECT_TRUE(heard_.has("pose refused")) << heard_.all();
}

// Catches a task that waits for ever when its request cannot be sent, or that requests without control.
TEST_P(FlightSequencerTest, ATaskWithoutControlIsNotAskedForAndFails) {
  begin({});
  ASSERT_TRUE(bench_->reach(FailsafeState::kSilent));
  companion::AutopilotTask task{core::Fence{}, 0.0};
  task.start(protocol::Task::kLand, bench_->world().now());
  const core::TimePoint from = bench_->world().now();
  while (task.failure() == companion::AutopilotTask::Failure::kNone && bench_->world().now() - from < seconds(10)) {
    bench_->tick();
    (void)task.tick(bench_->world().now(), bench_->controller());
  }
  EXPECT_EQ(task.failure(), companion::AutopilotTask::Failure::kNotSent);
  EXPECT_LE(bench_->world().now() - from, seconds(5));
  EXPECT_FALSE(bench_->world().autopilot().client_in_control());
  EXPECT_EQ(describe(task).text(), "landing: the request could not be sent");
}

TEST_P(FlightSequencerTest, ARefusalIsSaidAndTheWordIsTakenAgain) {
  begin({.take_control = true, .hold_s = 1000.0});
  bench_->world().autopilot().set_mode(sim::N1Mode::kP);
  ASSERT_TRUE(until([&] { return heard_.has("not_mode_f"); }, seconds(20))) << heard_.all();
  (void)until([] { return false; }, seconds(3));
  ASSERT_FALSE(ended_);
  bench_->world().autopilot().set_mode(sim::N1Mode::kF);
  (void)until([] { return false; }, seconds(3));
  EXPECT_EQ(bench_->noted().obtain_requests, 0U) << "control was requested although the order was refused";
  input_.toggle_control = true;
  EXPECT_TRUE(fly_for(seconds(1))) << heard_.all();
}

TEST_P(FlightSequencerTest, TheWordWorksAfterTheAutopilotRestarted) {
  begin({.take_control = true, .hold_s = 1000.0});
  ASSERT_TRUE(fly_for(seconds(1)));
  bench_->world().autopilot().happen(sim::N1EventKind::kRestart);
  ASSERT_TRUE(until([&] { return heard_.has("silent_cold"); }, seconds(2))) << heard_.all();
  (void)until([] { return false; }, seconds(5));
  ASSERT_FALSE(ended_);
  input_.toggle_control = true;
  EXPECT_TRUE(fly_for(seconds(1))) << heard_.all();
}

TEST_P(FlightSequencerTest, ARefusedPoseIsSaidInMetres) {
  RecordProperty("promise", "R14");
  begin({.take_control = true, .hold_s = 1000.0});
  ASSERT_TRUE(fly_for(seconds(3)));
  bench_->world().pose_source().set_faults({.jump_m = {0.31, 0.0, 0.0}});
  (void)until([] { return false; }, seconds(4));
  EXPECT_TRUE(heard_.has("pose refused: 0.3")) << heard_.all();
  EXPECT_TRUE(heard_.has(" m from the prediction, allowed 0.1")) << heard_.all();
}

TEST_P(FlightSequencerTest, WhereNothingArrivesTheOperatorReadsWhatToDo) {
  RecordProperty("promise", "R15");
  begin({.take_control = true, .hold_s = 1000.0});
  ASSERT_TRUE(fly_for(seconds(1)));
  bench_->world().autopilot_line().set_plugged(false);
  EXPECT_TRUE(until([&] { return heard_.has("turn the mode switch to P and back to F"); }, milliseconds(100)))
      << heard_.all();
  (void)until([] { return false; }, seconds(3));
  EXPECT_FALSE(ended_) << "it must keep trying";
  bench_->world().autopilot_line().set_plugged(true);
  EXPECT_TRUE(until([&] { return is_pilots(); }, seconds(1))) << heard_.all();
}

}  // namespace
}  // namespace m100::scenario
