// SPDX-License-Identifier: BSD-3-Clause
// Requests for the autopilot's own tasks: only in control, one at a time, and not repeated after a loss of control.
#include <gtest/gtest.h>

#include "host_tests/sim/ports/link_bench.h"

namespace m100::link {
namespace {

using protocol::Task;
using sim::LinkBench;
using sim::N1EventKind;
using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr protocol::TaskRequest kLanding{.sequence = 1, .task = Task::kLand};

struct TaskRequests : ::testing::Test {
  LinkBench bench{LinkBench::Options{}};
  int lost_answers = 0;  ///< one for each frame of the request that arrived

  void SetUp() override {
    ASSERT_TRUE(bench.take_control());
    bench.autopilot.on_event([this](const sim::N1Event& event) { lost_answers += event.name == "lost_ack" ? 1 : 0; });
  }
};

TEST_F(TaskRequests, AreAnsweredByTheirOwnName) {
  ASSERT_EQ(bench.link.request(kLanding, bench.clock.now()), core::Status::kOk);
  EXPECT_TRUE(bench.link.task_is_open());
  EXPECT_TRUE(bench.link.authority().answer.name.empty()) << "what was answered before is not its answer";
  EXPECT_EQ(bench.link.request(kLanding, bench.clock.now()), core::Status::kRefused) << "one is open";
  bench.run(milliseconds(60));
  EXPECT_FALSE(bench.link.task_is_open());
  EXPECT_EQ(bench.link.authority().answer.name, "started");
}

TEST_F(TaskRequests, AreRepeatedThreeTimesWhereNoAnswerComes) {
  bench.autopilot.happen(N1EventKind::kLoseAcks, 1000.0, sim::N1Request::kTask);
  ASSERT_EQ(bench.link.request(kLanding, bench.clock.now()), core::Status::kOk);
  bench.run(seconds(1));
  EXPECT_EQ(lost_answers, 3) << "protocol, section 3: sent at most";
  EXPECT_FALSE(bench.link.task_is_open());
  EXPECT_TRUE(bench.link.authority().answer.name.empty());
}

// Would catch a landing that is requested again after the pilot has taken the aircraft.
TEST_F(TaskRequests, AreNotRepeatedBehindALossOfControl) {
  RecordProperty("promise", "R4");
  bench.autopilot.happen(N1EventKind::kLoseAcks, 1000.0, sim::N1Request::kTask);
  ASSERT_EQ(bench.link.request(kLanding, bench.clock.now()), core::Status::kOk);
  bench.run(milliseconds(50));
  ASSERT_EQ(lost_answers, 1);
  bench.autopilot.set_mode(sim::N1Mode::kP);
  bench.run(seconds(1));
  EXPECT_EQ(lost_answers, 1);
  EXPECT_FALSE(bench.link.task_is_open());
  EXPECT_EQ(bench.link.request(kLanding, bench.clock.now()), core::Status::kRefused) << "control is the pilot's";
}

// Catches a motor request without control, a second one before the first is answered, and one that is repeated after
// the pilot has taken the aircraft.
TEST_F(TaskRequests, MotorsAreAskedForLikeATask) {
  const auto ask = [this](bool start) {
    return bench.link.request(protocol::MotorRequest{.start = start}, bench.clock.now());
  };
  ASSERT_TRUE(bench.vehicle.state().motors_on);
  ASSERT_EQ(ask(true), core::Status::kOk);
  EXPECT_EQ(ask(true), core::Status::kRefused) << "one is open";
  bench.run(milliseconds(60));
  EXPECT_EQ(bench.link.authority().answer.code, protocol::motor_ack::kAlready);
  bench.autopilot.happen(N1EventKind::kLoseAcks, 1000.0, sim::N1Request::kMotors);
  ASSERT_EQ(ask(true), core::Status::kOk);
  bench.run(milliseconds(50));
  bench.autopilot.set_mode(sim::N1Mode::kP);
  bench.run(seconds(1));
  EXPECT_EQ(lost_answers, 1);
  EXPECT_EQ(ask(true), core::Status::kRefused) << "control is the pilot's";
}

}  // namespace
}  // namespace m100::link
