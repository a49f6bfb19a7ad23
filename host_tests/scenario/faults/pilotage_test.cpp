// SPDX-License-Identifier: BSD-3-Clause
// The operator's part of m100 fly over the whole flight controller: who has the aircraft is judged at the autopilot.
#include "firmware/companion/fly/pilotage.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "host_tests/scenario/faults/fault_bench.h"

namespace m100::scenario {
namespace {

class Notebook final : public companion::Listener {
 public:
  void hear(core::TimePoint, std::string_view line) override { lines.emplace_back(line); }
  bool has(const std::string& text) const {
    return std::any_of(lines.begin(), lines.end(),
                       [&](const std::string& line) { return line.find(text) != std::string::npos; });
  }
  std::string all() const {
    std::string text;
    for (const std::string& line : lines) {
      text += line + "\n";
    }
    return text;
  }
  std::vector<std::string> lines;
};

class PilotageTest : public ::testing::TestWithParam<link::Channel> {
 protected:
  void begin(const companion::Wishes& wishes) {
    bench_.emplace(GetParam());
    pilotage_.emplace(wishes, app::kDefaultFlight.limits, bench_->controller(), heard_);
  }
  bool tick() {
    bench_->tick();
    const bool goes_on = pilotage_->tick(bench_->world().now(), input_);
    input_.word = false;
    return goes_on;
  }
  /// @returns after how long it came true; nothing: not in time, or the program ended before.
  template <typename Condition>
  std::optional<core::Duration> until(const Condition& condition, core::Duration at_most) {
    const core::TimePoint from = bench_->world().now();
    while (!condition()) {
      if (ended_ || bench_->world().now() - from >= at_most) {
        return std::nullopt;
      }
      ended_ = !tick();
    }
    return bench_->world().now() - from;
  }
  bool fly_for(core::Duration time) {
    const auto flies = [&] { return bench_->rung() == Rung::kNominal; };
    if (!until(flies, seconds(20))) {
      return false;
    }
    (void)until([] { return false; }, time);
    return flies();
  }
  static core::Vector<double, 3> bench_start() { return FaultBench().world().vehicle().state().position_w_m; }
  bool is_pilots() {
    return !bench_->world().autopilot().client_in_control() && !bench_->world().autopilot().virtual_rc_on();
  }

  std::optional<FaultBench> bench_;
  Notebook heard_;
  std::optional<companion::Pilotage> pilotage_;
  companion::OperatorInput input_;
  bool ended_ = false;
};
INSTANTIATE_TEST_SUITE_P(Faults, PilotageTest, ::testing::Values(link::Channel::kVirtualRc, link::Channel::kMovement));

// Catches a program that leaves with control kept: it sends one release, is told "again", and is gone.
TEST_P(PilotageTest, AfterTheLaddersReleaseTheTransmitterHasItAndTheProgramStays) {
  RecordProperty("promise", "R15");
  begin({.take_control = true, .hold_s = 1000.0});
  ASSERT_TRUE(fly_for(seconds(3))) << heard_.all();
  bench_->world().pose_source().set_faults({.silent = true});
  ASSERT_TRUE(until([&] { return bench_->rung() == Rung::kRelease; }, seconds(3)));
  const auto taken = until([&] { return is_pilots(); }, seconds(2));
  ASSERT_TRUE(taken.has_value()) << heard_.all();
  EXPECT_LE(*taken, seconds(1));
  ASSERT_FALSE(until([] { return false; }, seconds(2)) || ended_) << heard_.all();
  EXPECT_TRUE(heard_.has("pose old: 0.0")) << heard_.all();
  EXPECT_TRUE(heard_.has("the transmitter has the aircraft")) << heard_.all();
  EXPECT_FALSE(pilotage_->given_back()) << "not by the operator";
  bench_->world().pose_source().set_faults({});
  (void)until([] { return false; }, seconds(1));
  EXPECT_TRUE(is_pilots()) << "nobody flies unasked";
  input_.word = true;
  EXPECT_TRUE(fly_for(seconds(1))) << "and the operator's word counts again\n" << heard_.all();
}

// Catches a program that is started on the ground or by another place, and flies back there when it is told to fly.
TEST_P(PilotageTest, FarFromTheCoursesBeginningControlIsNotTakenAndItSaysWhy) {
  for (const bool once : {false, true}) {
    ended_ = false;
    begin({.take_control = true,
           .hold_s = 1000.0,
           .once = once,
           .begins_w_m = bench_start() + core::Vector<double, 3>{2.0, 0.0, 0.0},
           .reach_m = 1.5});
    (void)until([] { return false; }, seconds(10));
    EXPECT_TRUE(is_pilots());
    EXPECT_FALSE(pilotage_->flew());
    EXPECT_TRUE(heard_.has("fly there, or start m100 again here")) << heard_.all();
    EXPECT_EQ(ended_, once) << "a script ends, an operator is waited for";
  }
}

// Would catch a script that waits for ever for a source of pose that is dead.
TEST_P(PilotageTest, AScriptWithoutAPoseEndsAfterTwentySecondsAndSaysWhy) {
  begin({.take_control = true, .hold_s = 1000.0, .once = true});
  bench_->world().pose_source().set_faults({.silent = true});
  const core::TimePoint from = bench_->world().now();
  (void)until([] { return false; }, seconds(40));
  ASSERT_TRUE(ended_) << heard_.all();
  const double after_s = core::seconds<double>(bench_->world().now() - from);
  EXPECT_GT(after_s, 20.0);
  EXPECT_LT(after_s, 28.0) << "start-up takes some seconds of it";
  EXPECT_TRUE(heard_.has("control is not asked for yet")) << heard_.all();
  EXPECT_EQ(bench_->noted().obtain_requests, 0U);
}

// Nobody would give control back if the program died: then it is not taken, and what is only asked for goes back.
TEST_P(PilotageTest, WithoutTheSecondProcessControlIsNotAskedFor) {
  RecordProperty("promise", "R15");
  begin({.take_control = true, .hold_s = 1000.0});
  input_.guarded = false;
  (void)until([] { return false; }, seconds(12));
  EXPECT_EQ(bench_->noted().obtain_requests, 0U);
  EXPECT_TRUE(heard_.has("nobody would give it back if this program died")) << heard_.all();
  input_.guarded = true;
  input_.word = true;
  ASSERT_TRUE(until([&] { return bench_->noted().obtain_requests > 0U; }, seconds(5))) << heard_.all();
  input_.guarded = false;
  (void)until([] { return false; }, seconds(5));
  EXPECT_TRUE(is_pilots());
  EXPECT_FALSE(pilotage_->flew());
}

TEST_P(PilotageTest, AScriptsFlightEndsAfterTheReleaseAndNotBefore) {
  RecordProperty("promise", "R15");
  begin({.take_control = true, .hold_s = 1000.0, .once = true});
  ASSERT_TRUE(fly_for(seconds(3)));
  bench_->world().pose_source().set_faults({.silent = true});
  (void)until([] { return false; }, seconds(5));
  EXPECT_TRUE(ended_);
  EXPECT_TRUE(is_pilots());
  EXPECT_FALSE(pilotage_->given_back());
}

TEST_P(PilotageTest, TheOperatorsStopTheWordAndTheEndOfTheHoldEndInASecond) {
  RecordProperty("promise", "R15");
  for (const int way : {0, 1, 2}) {
    SCOPED_TRACE(way);
    ended_ = false;
    input_ = {};
    begin({.take_control = true, .hold_s = way == 2 ? 2.0 : 1000.0});
    ASSERT_TRUE(until([&] { return bench_->world().autopilot().client_in_control(); }, seconds(20)));
    (void)until([] { return false; }, seconds(2));
    input_.stops = way == 0 ? 1 : 0;
    input_.word = way == 1;
    const auto taken = until([&] { return is_pilots(); }, seconds(3));
    ASSERT_TRUE(taken.has_value()) << heard_.all();
    EXPECT_LE(*taken, seconds(1));
    EXPECT_FALSE(ended_) << "telemetry has not said so yet";
    (void)until([] { return false; }, milliseconds(100));
    EXPECT_TRUE(ended_);
    EXPECT_TRUE(pilotage_->given_back());
  }
}

TEST_P(PilotageTest, ARefusalIsSaidAndTheWordIsTakenAgain) {
  begin({.take_control = true, .hold_s = 1000.0});
  bench_->world().autopilot().set_mode(sim::N1Mode::kP);
  ASSERT_TRUE(until([&] { return heard_.has("not_mode_f"); }, seconds(20))) << heard_.all();
  (void)until([] { return false; }, seconds(3));
  ASSERT_FALSE(ended_);
  bench_->world().autopilot().set_mode(sim::N1Mode::kF);
  (void)until([] { return false; }, seconds(3));
  EXPECT_EQ(bench_->noted().obtain_requests, 0U) << "one order, and it was refused";
  input_.word = true;
  EXPECT_TRUE(fly_for(seconds(1))) << heard_.all();
}

TEST_P(PilotageTest, TheWordWorksAfterTheAutopilotRestarted) {
  begin({.take_control = true, .hold_s = 1000.0});
  ASSERT_TRUE(fly_for(seconds(1)));
  bench_->world().autopilot().happen(sim::N1Happening::kRestart);
  ASSERT_TRUE(until([&] { return heard_.has("silent_cold"); }, seconds(2))) << heard_.all();
  (void)until([] { return false; }, seconds(5));
  ASSERT_FALSE(ended_);
  input_.word = true;
  EXPECT_TRUE(fly_for(seconds(1))) << heard_.all();
}

TEST_P(PilotageTest, ARefusedPoseIsToldInMetres) {
  RecordProperty("promise", "R14");
  begin({.take_control = true, .hold_s = 1000.0});
  ASSERT_TRUE(fly_for(seconds(3)));
  bench_->world().pose_source().set_faults({.jump_m = {0.31, 0.0, 0.0}});
  (void)until([] { return false; }, seconds(4));
  EXPECT_TRUE(heard_.has("pose refused: 0.3")) << heard_.all();
  EXPECT_TRUE(heard_.has(" m from where it must be, allowed 0.1")) << heard_.all();
}

TEST_P(PilotageTest, WhereNothingArrivesTheOperatorReadsWhatToDo) {
  RecordProperty("promise", "R15");
  begin({.take_control = true, .hold_s = 1000.0});
  ASSERT_TRUE(fly_for(seconds(1)));
  bench_->world().autopilot_line().set_plugged(false);
  EXPECT_TRUE(until([&] { return heard_.has("turn the mode switch to P and back to F"); }, milliseconds(100)))
      << heard_.all();
  (void)until([] { return false; }, seconds(3));
  EXPECT_FALSE(ended_) << "it goes on trying";
  bench_->world().autopilot_line().set_plugged(true);
  EXPECT_TRUE(until([&] { return is_pilots(); }, seconds(1))) << heard_.all();
}

}  // namespace
}  // namespace m100::scenario
