// SPDX-License-Identifier: BSD-3-Clause
// From the operator's orders to requests for control, seen at the emulated autopilot.
#include "firmware/app/operator_orders.h"

#include <gtest/gtest.h>

#include <cmath>

#include "firmware/app/command_sender.h"
#include "firmware/log/records.h"
#include "firmware/mpc/generated/gain_table.h"
#include "host_tests/sim/ports/link_bench.h"

namespace m100::app {
namespace {

using safety::FailsafeState;
using std::chrono::milliseconds;
using std::chrono::seconds;

struct OperatorOrdersTest : ::testing::Test {
  sim::LinkBench bench{{}};
  OperatorOrders orders{seconds(3)};
  FailsafeState state = FailsafeState::kSilent;
  bool in_reach = true;

  void SetUp() override { ASSERT_TRUE(bench.run_until(safety::AuthorityStage::kReady)); }
  void tick() {
    orders.update(in_reach, state, bench.link, bench.clock.now());
    bench.tick();
    orders.release_unused(state, bench.link, bench.clock.now());
  }
  /// Ticks after which control is ours, or not ours any more; at most this many.
  int ticks_until(bool ours, int most) {
    int ticks = 0;
    for (; bench.link.authority().in_control != ours && ticks < most; ++ticks) {
      tick();
    }
    return ticks;
  }
  std::uint32_t requests() const { return bench.autopilot.record().obtain_requests; }
  safety::OrderStatus status() { return orders.status(in_reach, bench.clock.now()); }
};

// Catches an order whose requests go on after its time: two seconds apart, the third would come after four.
TEST_F(OperatorOrdersTest, AnOrderToFlyStandsForItsTimeAndNoLonger) {
  bench.autopilot.happen(sim::N1EventKind::kTake, 'm');  // control is never granted
  orders.add(log::kOrderEngage);
  tick();
  EXPECT_EQ(orders.acting(), log::kOrderEngage);
  EXPECT_TRUE(status().engages);
  EXPECT_FALSE(orders.status(false, bench.clock.now()).engages);
  ticks_until(true, 297);
  EXPECT_EQ(orders.acting(), 0U);
  EXPECT_TRUE(status().engages);
  ticks_until(true, 4);
  EXPECT_FALSE(status().engages);
  ticks_until(true, 500);
  EXPECT_EQ(requests(), 2U);
}

TEST_F(OperatorOrdersTest, WhatIsOutOfReachOrFliesAlreadyAsksForNothing) {
  for (const bool flies : {false, true}) {
    in_reach = flies;
    state = flies ? FailsafeState::kNominal : FailsafeState::kSilent;
    orders.add(log::kOrderEngage);
    ticks_until(true, 100);
    EXPECT_EQ(requests(), 0U);
    EXPECT_FALSE(status().engages);
  }
}

TEST_F(OperatorOrdersTest, AReleaseWithdrawsAnOrderThatWaits) {
  orders.add(log::kOrderEngage);
  ticks_until(true, 50);
  ASSERT_EQ(requests(), 1U);
  orders.add(log::kOrderRelease);
  tick();
  EXPECT_TRUE(status().releases && !status().engages);
  tick();
  EXPECT_FALSE(status().releases);
  ticks_until(true, 400);
  EXPECT_EQ(requests(), 1U);
}

TEST_F(OperatorOrdersTest, ControlThatNothingUsesGoesBackAfterEightTenthsOfASecond) {
  for (const bool is_used : {true, false}) {
    state = is_used ? FailsafeState::kLevel : FailsafeState::kSilent;
    orders.add(log::kOrderEngage);
    ASSERT_LT(ticks_until(true, 1000), 900) << is_used;
    EXPECT_EQ(ticks_until(false, 200), is_used ? 200 : 82) << "80 ticks, and two of the line";
  }
}

TEST_F(OperatorOrdersTest, ATaskIsRequestedOnceAndSaid) {
  state = FailsafeState::kLevel;
  orders.add(log::kOrderEngage);
  ticks_until(true, 1000);
  EXPECT_EQ(orders.begin_task(protocol::Task::kLand, bench.link, bench.clock.now()), core::Status::kOk);
  orders.add(log::kOrderLands);
  tick();
  EXPECT_EQ(orders.acting(), log::kOrderTask | log::kOrderLands);
  EXPECT_TRUE(status().task_flies && !orders.takes_off());
  orders.add(log::kOrderTakesOff);
  tick();
  EXPECT_TRUE(status().task_flies && orders.takes_off());
  tick();
  EXPECT_FALSE(status().task_flies || orders.takes_off());
}

// Each reason for which no command leaves is said as it is.
TEST(CommandSenderTest, SaysWhyNothingLeaves) {
  for (const link::Channel channel : {link::Channel::kVirtualRc, link::Channel::kMovement}) {
    sim::LinkBench bench(sim::LinkBench::over(channel));
    CommandSender<double> sender(mpc::generated::kVehicle, channel);
    const ctl::Excitation<double> none{{}};
    safety::SupervisedCommand<double> supervised;
    const auto send = [&] { return sender.send(supervised, supervised.command, none, bench.link, bench.clock.now()); };
    EXPECT_EQ(send(), core::Status::kRefused) << "silent by the failsafe";
    supervised.transmit = true;
    EXPECT_EQ(send(), core::Status::kNotReady) << "not in control";
    ASSERT_TRUE(bench.take_control());
    bench.commanding = false;
    bench.run(milliseconds(100));
    supervised.command.climb_m_s = std::nan("");
    EXPECT_EQ(send(), core::Status::kOutOfRange);
    supervised.command.climb_m_s = 0.5;
    bench.cable().a_to_b().set_faults({.longest_write = 1});
    EXPECT_EQ(send(), core::Status::kOk);
    EXPECT_NEAR(sender.update(true, {}).climb_m_s, 0.5, 0.02);
    EXPECT_EQ(send(), core::Status::kNotReady) << "the channel's rate";
    bench.run(milliseconds(50));
    EXPECT_EQ(send(), core::Status::kResourceExhausted) << "the line still holds the command before";
  }
}

}  // namespace
}  // namespace m100::app
