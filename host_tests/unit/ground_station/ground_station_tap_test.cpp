// SPDX-License-Identifier: BSD-3-Clause
// Orders that a room sends within one tick: no order is lost because of another one.
#include "firmware/companion/ground_station/guided_mode.h"

#include <gtest/gtest.h>

#include <vector>

#include "hal/mock/manual_clock.h"
#include "hal/mock/uart_pair.h"

namespace m100::companion {
namespace {

constexpr mavlink::Address kStation{.system = 255, .component = 190};
constexpr std::uint16_t kGuided = 92, kPause = 193, kRequestMessage = 512;

struct GroundStationTapTest : ::testing::Test {
  hal::ManualClock clock;
  hal::UartPair pair{clock, 0};
  GroundStationTap line{pair.a()};
  std::uint8_t sequence = 0;

  void say(std::uint16_t command, float param1, std::uint8_t system = 1) {
    send(mavlink::CommandLong{.param1 = param1, .command = command, .target_system = system});
  }
  template <typename Message>
  void send(const Message& message) {
    const mavlink::Frame frame = mavlink::encode(message, kStation, sequence++);
    EXPECT_EQ(pair.b().write(frame.bytes()).value_or(0), frame.bytes().size());
    std::vector<std::byte> got(frame.bytes().size());
    EXPECT_EQ(line.read(got).value_or(0), got.size());
  }
  /// The waiting orders; each tick takes one.
  std::vector<std::pair<int, float>> taken() {
    std::vector<std::pair<int, float>> all;
    while (const auto order = line.take_order()) {
      all.emplace_back(order->message.command, order->message.param1);
    }
    return all;
  }
};
using FlightFiles = std::vector<std::pair<int, float>>;

// Catches an order to release that is lost because a ground station requested a message in the same tick.
TEST_F(GroundStationTapTest, OrdersOfOneTickAreTakenOneByOne) {
  RecordProperty("promise", "R15");
  say(kGuided, 0.F);
  say(kRequestMessage, 1.F);
  say(kGuided, 1.F, 7);  // another aircraft's
  EXPECT_EQ(taken(), (FlightFiles{{kGuided, 0.F}, {kRequestMessage, 1.F}}));
  EXPECT_TRUE(taken().empty());
}

// Catches a release, or an order to hold, that finds no room in the queue after the requests of a stall.
TEST_F(GroundStationTapTest, AnOrderToStopAlwaysFindsRoom) {
  RecordProperty("promise", "R15");
  for (int i = 0; i < 20; ++i) {
    say(kRequestMessage, static_cast<float>(i));
  }
  say(kPause, 0.F);
  for (int i = 0; i < 20; ++i) {
    say(kRequestMessage, 1.F);
    say(kPause, 1.F);
  }
  say(kGuided, 0.F);
  say(kGuided, 1.F);
  say(kPause, 0.F);
  const FlightFiles all = taken();
  EXPECT_LE(all.size(), GroundStationTap::kMaxCommands) << "bounded";
  ASSERT_FALSE(all.empty());
  EXPECT_EQ(all.back(), (std::pair<int, float>{kGuided, 0.F})) << "and nothing that came in excess flies behind it";
}

// The counts in the result of a flight: zero before anything was received, and each message counted once.
TEST_F(GroundStationTapTest, WhatWasHeardIsCounted) {
  const GroundStationStats& heard = line.stats();
  for (const std::uint32_t count :
       {heard.goals, heard.orders, heard.requests, heard.orders_lost, heard.requests_lost}) {
    EXPECT_EQ(count, 0U);
  }
  for (std::size_t i = 0; i < GroundStationTap::kMaxCommands + 3; ++i) {
    say(kRequestMessage, 1.F);
  }
  say(kRequestMessage, 1.F, 9);  // another aircraft's
  EXPECT_EQ(heard.orders, GroundStationTap::kMaxCommands + 3);
  EXPECT_EQ(heard.orders_lost, 3U);
  const std::size_t most = [&] {
    std::size_t asked = 0;
    for (; asked < 100 && line.answers().size() == asked; ++asked) {
      send(mavlink::MissionRequestList{.target_system = 1});
    }
    return asked;
  }();
  EXPECT_EQ(heard.requests, most);
  EXPECT_EQ(heard.requests_lost, 1U) << "the one that found no room, of " << most;
  EXPECT_EQ(heard.goals, 0U);
}

// Catches an answer to a request for another aircraft's lists, or for a parameter that does not exist.
TEST_F(GroundStationTapTest, WhatIsNotOursIsNotAnswered) {
  const auto named = [](std::string_view name) {
    mavlink::ParamRequestRead request{.param_index = -1, .target_system = 1};
    std::ranges::copy(name, request.param_id.begin());
    return request;
  };
  send(mavlink::MissionRequestList{.target_system = 7});
  send(named("MAV_SYS"));
  send(named("MAV_SYS_ID_AND_1"));
  send(mavlink::ParamRequestRead{.param_index = 1, .target_system = 1});
  EXPECT_TRUE(line.answers().empty());
  send(named("MAV_SYS_ID"));
  ASSERT_EQ(line.answers().size(), 1U);
  EXPECT_EQ(std::get<mavlink::ParamValue>(line.answers()[0]).param_value, 1.F);
  line.clear_answers();
  EXPECT_TRUE(line.answers().empty());
}

}  // namespace
}  // namespace m100::companion
