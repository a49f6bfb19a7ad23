// SPDX-License-Identifier: BSD-3-Clause
// Missions: the transfer from a room (items that come twice, late or never, and invalid items), and how a mission is
// flown.
#include "firmware/companion/ground_station/mission.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "firmware/companion/ground_station/mission_transfer.h"
#include "firmware/companion/ground_station/parameters.h"

namespace m100::companion {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr mavlink::Address kStation{.system = 9, .component = 190};
constexpr mavlink::Address kOther{.system = 8, .component = 190};
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

template <typename Item, typename Number>
Item item_at(std::uint16_t seq, Number x, Number y, float z_m) {
  return {.param4 = kNan,
          .x = x,
          .y = y,
          .z = z_m,
          .seq = seq,
          .command = 16,
          .target_system = 1,
          .frame = 1,
          .autocontinue = 1};
}
mavlink::MissionItemInt item(std::uint16_t seq, double x_m, double y_m, double z_m) {
  const auto tenths_of_mm = [](double metres) { return static_cast<std::int32_t>(std::lround(metres * 1e4)); };
  return item_at<mavlink::MissionItemInt>(seq, tenths_of_mm(x_m), tenths_of_mm(y_m), static_cast<float>(z_m));
}
constexpr auto older_item = item_at<mavlink::MissionItem, float>;

struct TransferTest : ::testing::Test {
  MissionTransfer transfer;
  core::TimePoint now{seconds(10)};

  std::vector<Reply> receive(const RequestMessage& message, mavlink::Address from = kStation, bool is_flown = false) {
    Replies replies;
    transfer.receive({message, from}, is_flown, now, replies);
    return {replies.all().begin(), replies.all().end()};
  }
  std::vector<Reply> wait(core::Duration time) {
    Replies replies;
    std::vector<Reply> all;
    for (const core::TimePoint end = now + time; now < end;) {
      now += core::kTickPeriod;
      replies.clear();
      transfer.tick(now, replies);
      all.insert(all.end(), replies.all().begin(), replies.all().end());
    }
    return all;
  }
  /// The number of the item that the only reply requests; -1: the reply is another one.
  static int asked(const std::vector<Reply>& replies) {
    const auto* const request = replies.size() == 1 ? std::get_if<mavlink::MissionRequestInt>(&replies[0]) : nullptr;
    return request == nullptr ? -1 : request->seq;
  }
  /// The result in the only reply; -1: the reply is another one.
  static int result(const std::vector<Reply>& replies) {
    const auto* const ack = replies.size() == 1 ? std::get_if<mavlink::MissionAck>(&replies[0]) : nullptr;
    return ack == nullptr ? -1 : ack->type;
  }
  void carry_over(std::uint16_t count) {
    EXPECT_EQ(asked(receive(mavlink::MissionCount{.count = count})), 0);
    for (std::uint16_t seq = 0; seq + 1 < count; ++seq) {
      EXPECT_EQ(asked(receive(item(seq, seq, 0.0, -1.5))), seq + 1);
    }
    EXPECT_EQ(result(receive(item(static_cast<std::uint16_t>(count - 1), 0.0, 0.0, -1.5))), mission_result::kAccepted);
    EXPECT_EQ(transfer.items().size(), count);
  }
};

TEST_F(TransferTest, ItemsAreAskedForOneByOneAndGivenBack) {
  carry_over(3);
  const std::vector<Reply> count = receive(mavlink::MissionRequestList{}, kOther);
  ASSERT_EQ(count.size(), 1U);
  EXPECT_EQ(std::get<mavlink::MissionCount>(count[0]).count, 3);
  EXPECT_EQ(std::get<mavlink::MissionCount>(count[0]).target_system, kOther.system);
  const std::vector<Reply> second = receive(mavlink::MissionRequestInt{.seq = 1}, kOther);
  ASSERT_EQ(second.size(), 1U);
  EXPECT_EQ(std::get<mavlink::MissionItemInt>(second[0]).x, 10000);
  EXPECT_EQ(std::get<mavlink::MissionItemInt>(second[0]).target_system, kOther.system);
  EXPECT_EQ(result(receive(mavlink::MissionRequestInt{.seq = 3})), mission_result::kInvalidSequence);
  EXPECT_EQ(result(receive(mavlink::MissionClearAll{})), mission_result::kAccepted);
  EXPECT_TRUE(transfer.items().empty());
}

// Would catch a transfer that stops for ever after a lost packet, and one that stores an item twice.
TEST_F(TransferTest, WhatIsLostIsAskedForAgainAndWhatComesTwiceIsOne) {
  EXPECT_EQ(asked(receive(mavlink::MissionCount{.count = 2})), 0);
  EXPECT_EQ(asked(wait(MissionTransfer::kRetryInterval)), 0);
  EXPECT_EQ(asked(receive(item(0, 1.0, 0.0, -1.5))), 1);
  EXPECT_TRUE(receive(item(0, 1.0, 0.0, -1.5)).empty());
  EXPECT_TRUE(receive(item(1, 1.0, 0.0, -1.5), kOther).empty()) << "another one's item is not of this list";
  EXPECT_EQ(asked(wait(MissionTransfer::kRetryInterval)), 1);
  EXPECT_EQ(result(receive(item(1, 2.0, 0.0, -1.5))), mission_result::kAccepted);
  EXPECT_EQ(result(receive(item(1, 2.0, 0.0, -1.5))), mission_result::kAccepted) << "our answer was lost";
  EXPECT_EQ(transfer.items().size(), 2U);
}

// Would catch a refused mission that is acknowledged as accepted because an earlier list had the same length.
TEST_F(TransferTest, RepeatingTheEndOfARefusedListIsNotAnsweredAsAccepted) {
  carry_over(2);
  mavlink::MissionItemInt global = item(1, 2.0, 0.0, -1.5);
  global.frame = 5;
  EXPECT_EQ(asked(receive(mavlink::MissionCount{.count = 2})), 0);
  EXPECT_EQ(asked(receive(item(0, 9.0, 0.0, -1.5))), 1);
  EXPECT_EQ(result(receive(global)), mission_result::kUnsupportedFrame);
  EXPECT_EQ(result(receive(global)), mission_result::kUnsupportedFrame) << "our answer was lost";
  EXPECT_TRUE(receive(item(0, 9.0, 0.0, -1.5)).empty());
  EXPECT_EQ(asked(receive(mavlink::MissionCount{.count = 2})), 0);
  EXPECT_TRUE(receive(mavlink::MissionAck{.type = mission_result::kCancelled}).empty());
  EXPECT_TRUE(receive(item(1, 9.0, 0.0, -1.5)).empty()) << "it was cancelled";
  carry_over(1);
  EXPECT_EQ(result(receive(mavlink::MissionClearAll{})), mission_result::kAccepted);
  EXPECT_TRUE(receive(item(0, 9.0, 0.0, -1.5)).empty()) << "it was cleared";
}

TEST_F(TransferTest, WhatIsNotWholeReplacesNothing) {
  carry_over(2);
  const std::uint32_t edition = transfer.edition();
  EXPECT_EQ(asked(receive(mavlink::MissionCount{.count = 3})), 0);
  EXPECT_EQ(asked(receive(item(0, 9.0, 0.0, -1.5))), 1);
  const std::vector<Reply> all = wait(MissionTransfer::kRetryInterval * (MissionTransfer::kMaxRequestsPerItem + 2));
  ASSERT_FALSE(all.empty());
  EXPECT_EQ(std::get<mavlink::MissionAck>(all.back()).type, mission_result::kCancelled);
  EXPECT_EQ(all.size(), MissionTransfer::kMaxRequestsPerItem) << "asked again, and then given up";
  EXPECT_EQ(asked(receive(mavlink::MissionCount{.count = 3})), 0);
  EXPECT_TRUE(receive(mavlink::MissionAck{.type = mission_result::kCancelled}).empty());
  EXPECT_FALSE(transfer.is_open());
  EXPECT_EQ(transfer.items().size(), 2U);
  EXPECT_EQ(transfer.items()[1].seq, 1);
  EXPECT_EQ(transfer.edition(), edition);
}

// A sender from before 2020 requests with MISSION_REQUEST and sends MISSION_ITEM, in metres. Would catch a vehicle that
// does not answer it.
TEST_F(TransferTest, OlderMessagesCarryTheSameItems) {
  EXPECT_EQ(asked(receive(mavlink::MissionCount{.count = 2})), 0);
  EXPECT_EQ(asked(receive(older_item(0, 1.25F, -3.F, -1.5F))), 1);
  EXPECT_EQ(result(receive(older_item(1, -1000.F, 1000.F, -1.5F))), mission_result::kAccepted);
  ASSERT_EQ(transfer.items().size(), 2U);
  EXPECT_EQ(transfer.items()[0].x, 12500);
  EXPECT_EQ(transfer.items()[0].y, -30000);
  EXPECT_EQ(transfer.items()[0].z, -1.5F);
  const std::vector<Reply> given = receive(mavlink::MissionRequest{.seq = 1}, kOther);
  ASSERT_EQ(given.size(), 1U);
  EXPECT_EQ(std::get<mavlink::MissionItemInt>(given[0]).x, -10'000'000);
  EXPECT_EQ(std::get<mavlink::MissionItemInt>(given[0]).target_system, kOther.system);
  EXPECT_EQ(result(receive(mavlink::MissionRequest{.seq = 2})), mission_result::kInvalidSequence);
  EXPECT_EQ(result(receive(mavlink::MissionRequest{.seq = 0, .mission_type = 1})), mission_result::kUnsupported);
}

TEST_F(TransferTest, AnOlderItemThatIsNoPlaceIsRefused) {
  EXPECT_EQ(validate(to_item_int(older_item(0, kNan, 0.F, -1.F))), mission_result::kInvalidX);
  EXPECT_EQ(validate(to_item_int(older_item(0, 0.F, 1e30F, -1.F))), mission_result::kInvalidY);
  EXPECT_EQ(validate(to_item_int(older_item(0, 1000.5F, 0.F, -1.F))), mission_result::kInvalidX);
  EXPECT_EQ(validate(to_item_int(older_item(0, 0.F, 0.F, kNan))), mission_result::kInvalidZ);
  mavlink::MissionItem by_degrees = older_item(0, 47.3F, 8.5F, 1.F);
  by_degrees.frame = 3;
  EXPECT_EQ(validate(to_item_int(by_degrees)), mission_result::kUnsupportedFrame);
}

TEST_F(TransferTest, AMissionThatFliesIsNotReplaced) {
  carry_over(2);
  EXPECT_EQ(result(receive(mavlink::MissionCount{.count = 1}, kStation, true)), mission_result::kDenied);
  EXPECT_EQ(result(receive(mavlink::MissionClearAll{}, kStation, true)), mission_result::kDenied);
  EXPECT_EQ(transfer.items().size(), 2U);
}

// Would catch an upload that replaces the mission in flight because the mission was started during the upload.
TEST_F(TransferTest, AMissionThatIsStartedDuringATransferIsNotReplacedByIt) {
  carry_over(2);
  const std::uint32_t edition = transfer.edition();
  EXPECT_EQ(asked(receive(mavlink::MissionCount{.count = 2})), 0);
  EXPECT_EQ(asked(receive(item(0, 9.0, 0.0, -1.5))), 1);
  EXPECT_EQ(result(receive(item(1, 9.0, 0.0, -1.5), kStation, true)), mission_result::kDenied);
  EXPECT_EQ(result(receive(item(1, 9.0, 0.0, -1.5), kStation, true)), mission_result::kDenied) << "our answer was lost";
  EXPECT_FALSE(transfer.is_open());
  EXPECT_EQ(transfer.edition(), edition);
}

// Would catch a transfer that another station can end without the uploading station noticing.
TEST_F(TransferTest, NobodyElseForgetsTheItemsDuringATransfer) {
  EXPECT_EQ(asked(receive(mavlink::MissionCount{.count = 2})), 0);
  EXPECT_EQ(result(receive(mavlink::MissionClearAll{}, kOther)), mission_result::kDenied);
  EXPECT_TRUE(transfer.is_open());
  EXPECT_EQ(result(receive(mavlink::MissionClearAll{})), mission_result::kAccepted);
  EXPECT_FALSE(transfer.is_open());
}

TEST_F(TransferTest, OneTransferAtATime) {
  EXPECT_EQ(asked(receive(mavlink::MissionCount{.count = 2})), 0);
  EXPECT_EQ(result(receive(mavlink::MissionCount{.count = 2}, kOther)), mission_result::kDenied);
  EXPECT_EQ(asked(receive(mavlink::MissionCount{.count = 1})), 0) << "its own partner may begin anew";
}

TEST_F(TransferTest, WhatIsNotThereIsRefused) {
  EXPECT_EQ(result(receive(mavlink::MissionCount{.count = MissionTransfer::kMaxItems + 1})), mission_result::kNoSpace);
  EXPECT_EQ(result(receive(mavlink::MissionCount{.count = 1, .mission_type = 1})), mission_result::kUnsupported);
  EXPECT_EQ(result(receive(mavlink::MissionRequestList{.mission_type = 2})), mission_result::kUnsupported);
  EXPECT_TRUE(receive(item(0, 0.0, 0.0, -1.5)).empty()) << "nobody announced it";
}

struct JudgedItem {
  const char* name;
  mavlink::MissionItemInt item;
  std::uint8_t result;
};
mavlink::MissionItemInt with(void (*change)(mavlink::MissionItemInt&)) {
  mavlink::MissionItemInt changed = item(0, 1.0, 2.0, -1.5);
  change(changed);
  return changed;
}
using Item = mavlink::MissionItemInt;
struct Judge : ::testing::TestWithParam<JudgedItem> {};
TEST_P(Judge, SaysWhatIsWrong) { EXPECT_EQ(validate(GetParam().item), GetParam().result); }
INSTANTIATE_TEST_SUITE_P(
    Table, Judge,
    ::testing::Values(
        JudgedItem{"Waypoint", item(0, 1.0, 2.0, -1.5), mission_result::kAccepted},
        JudgedItem{"NothingSet", with([](Item& i) { i.param1 = i.param2 = i.param3 = kNan; }),
                   mission_result::kAccepted},
        JudgedItem{"Land", with([](Item& i) { i.command = 21; }), mission_result::kUnsupported},
        JudgedItem{"Global", with([](Item& i) { i.frame = 6; }), mission_result::kUnsupportedFrame},
        JudgedItem{"NegativeHold", with([](Item& i) { i.param1 = -1.F; }), mission_result::kInvalidParam1},
        JudgedItem{"EndlessHold", with([](Item& i) { i.param1 = std::numeric_limits<float>::infinity(); }),
                   mission_result::kInvalidParam1},
        JudgedItem{"NegativeRadius", with([](Item& i) { i.param2 = -1.F; }), mission_result::kInvalidParam2},
        JudgedItem{"PassBy", with([](Item& i) { i.param3 = 1.F; }), mission_result::kInvalidParam3},
        JudgedItem{"WildHeading", with([](Item& i) { i.param4 = 1e9F; }), mission_result::kInvalidParam4},
        JudgedItem{"FarX", with([](Item& i) { i.x = std::numeric_limits<std::int32_t>::min(); }),
                   mission_result::kInvalidX},
        JudgedItem{"FarY", with([](Item& i) { i.y = 10'000'001; }), mission_result::kInvalidY},
        JudgedItem{"NoHeight", with([](Item& i) { i.z = kNan; }), mission_result::kInvalidZ}),
    [](const auto& judged) { return judged.param.name; });

struct MissionTest : ::testing::Test {
  ref::Trajectory<double> trajectory;
  core::Fence fence{.side = {{{-5.0, 5.0}, {-5.0, 5.0}, {0.5, 4.0}}}};
  ref::SpeedLimits limits;
  GoalPlanner<double> goals{trajectory, fence, limits};
  Mission<double> mission{goals};
  std::vector<mavlink::MissionItemInt> items;
  core::TimePoint now{seconds(10)};
  std::vector<std::uint16_t> reached;
  double slowest_m_s = 1e9, farthest_m = 0.0;
  bool flies = true;

  void SetUp() override {
    ref::Waypoint<double> start;
    start.position_w_m = {0.0, 0.0, 1.5};
    trajectory.hold(start);
    trajectory.start(now);
  }
  /// Lets time pass; the aircraft follows its reference exactly.
  void pass(core::Duration time) {
    slowest_m_s = 1e9;
    for (const core::TimePoint end = now + time; now < end;) {
      now += core::kTickPeriod;
      const ref::Window<double> window = trajectory.window(now, core::Duration{0});
      est::Estimate<double> estimate;
      estimate.x.position_m = window.x[0].position_m;
      estimate.y.position_m = window.y[0].position_m;
      estimate.height_m = window.height.position_m;
      slowest_m_s = std::min(slowest_m_s, std::hypot(window.x[0].velocity_m_s, window.y[0].velocity_m_s));
      farthest_m = std::max({farthest_m, std::abs(estimate.x.position_m), std::abs(estimate.y.position_m)});
      if (const auto seq = mission.update(items, now, estimate, flies)) {
        reached.push_back(*seq);
      }
    }
  }
  core::Vector<double, 3> reference() const { return goals.reference(now); }
};

TEST_F(MissionTest, FliesItsItemsInOrderAndHoldsAtThem) {
  items = {item(0, 1.0, 0.0, -1.5), item(1, 1.0, 1.0, -2.0), item(2, 0.0, 0.0, -1.5)};
  items[1].param1 = 3.F;
  items[1].param4 = 90.F;
  ASSERT_TRUE(mission.start(items, 0, 0, now, true));
  pass(seconds(4));
  EXPECT_EQ(reached, (std::vector<std::uint16_t>{0}));
  pass(milliseconds(2500));
  EXPECT_EQ(reached, (std::vector<std::uint16_t>{0, 1}));
  EXPECT_NEAR(reference().y(), -1.0, 0.02) << "east is our minus y";
  EXPECT_NEAR(reference().z(), 2.0, 0.02);
  EXPECT_NEAR(goals.yaw(now), -core::kPi / 2.0, 0.02) << "clockwise from above is ours with a minus";
  pass(seconds(1));
  EXPECT_EQ(mission.current(), 1) << "it holds there for three seconds";
  pass(seconds(8));
  EXPECT_EQ(reached, (std::vector<std::uint16_t>{0, 1, 2}));
  EXPECT_EQ(mission.state(), MissionState::kComplete);
  EXPECT_NEAR(goals.yaw(now), -core::kPi / 2.0, 0.02) << "an item without a heading keeps the one that is";
}

// Would catch a mission that stops at each of its points although no item asks for it.
TEST_F(MissionTest, PassesPointsWithARadiusWithoutAStop) {
  items = {item(0, 2.0, 0.0, -1.5), item(1, 3.5, 1.0, -1.5), item(2, 4.0, 3.0, -1.5)};
  items[0].param2 = items[1].param2 = 0.5F;
  ASSERT_TRUE(mission.start(items, 0, 2, now, true));
  pass(seconds(1));
  while (reached.size() < 2 && now < core::TimePoint{seconds(30)}) {
    pass(milliseconds(10));
    ASSERT_GT(slowest_m_s, 0.2) << "it stopped on its way, at " << reached.size() << " points";
  }
  pass(seconds(8));
  EXPECT_EQ(reached.size(), 3U);
}

TEST_F(MissionTest, StaysInsideTheFence) {
  items = {item(0, 50.0, 0.0, -1.5), item(1, 0.0, 50.0, -1.5)};
  ASSERT_TRUE(mission.start(items, 0, 1, now, true));
  pass(seconds(30));
  EXPECT_EQ(reached.size(), 2U) << "what lies beyond the fence is flown to at its side";
  EXPECT_LE(farthest_m, 5.0 + 1e-9);
}

TEST_F(MissionTest, WhateverElseMovesTheAircraftPausesItAndItGoesOnByOrder) {
  items = {item(0, 3.0, 0.0, -1.5), item(1, 0.0, 0.0, -1.5)};
  EXPECT_FALSE(mission.resume(items, now, true)) << "nothing is paused";
  EXPECT_FALSE(mission.start(items, 2, 0, now, true)) << "there is no such item";
  EXPECT_FALSE(mission.start(items, 0, 0, now, false)) << "nothing flies";
  ASSERT_TRUE(mission.start(items, 0, 0, now, true));
  pass(seconds(1));
  flies = false;  // the failsafe has taken over
  pass(milliseconds(10));
  EXPECT_EQ(mission.state(), MissionState::kPaused);
  flies = true;
  pass(seconds(5));
  EXPECT_EQ(mission.state(), MissionState::kPaused) << "nothing goes on by itself";
  EXPECT_TRUE(reached.empty());
  EXPECT_FALSE(mission.resume(items, now, false));
  ASSERT_TRUE(mission.resume(items, now, true));
  pass(seconds(10));
  EXPECT_EQ(reached, (std::vector<std::uint16_t>{0, 1}));
  mission.reset({});
  EXPECT_EQ(mission.state(), MissionState::kNone);
}

TEST_F(MissionTest, AnItemMayAskForAPauseBehindIt) {
  items = {item(0, 1.0, 0.0, -1.5), item(1, 0.0, 0.0, -1.5)};
  items[0].autocontinue = 0;
  ASSERT_TRUE(mission.start(items, 0, 0, now, true));
  pass(seconds(6));
  EXPECT_EQ(mission.state(), MissionState::kPaused);
  EXPECT_EQ(mission.current(), 1);
  EXPECT_NEAR(reference().x(), 1.0, 1e-6);
}

struct ParametersTest : ::testing::Test {
  model::Vehicle vehicle;
  app::FlightConfig config;
  Parameters parameters{{vehicle, config, ref::SpeedLimits{}}};

  static mavlink::ParamRequestRead named(std::string_view name) {
    mavlink::ParamRequestRead request{.param_index = -1};
    std::ranges::copy(name, request.param_id.begin());
    return request;
  }
  std::vector<mavlink::ParamValue> answers(const RequestMessage& message, int ticks) {
    std::vector<mavlink::ParamValue> all;
    Replies replies;
    parameters.receive({message, kStation}, replies);
    for (int tick = 0; tick < ticks; ++tick) {
      parameters.tick(replies);
      for (const Reply& reply : replies.all()) {
        all.push_back(std::get<mavlink::ParamValue>(reply));
      }
      replies.clear();
    }
    return all;
  }
};

TEST_F(ParametersTest, AllAreSentOneATickAndOnce) {
  const std::vector<mavlink::ParamValue> all = answers(mavlink::ParamRequestList{}, 200);
  ASSERT_EQ(all.size(), parameter_entries().size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(all[i].param_index, i);
    EXPECT_EQ(all[i].param_count, all.size());
    EXPECT_EQ(std::string_view(all[i].param_id.data(), parameter_entries()[i].name.size()),
              parameter_entries()[i].name);
  }
}

TEST_F(ParametersTest, OneIsReadByNameOrIndexAndWhatIsNotThereIsNot) {
  const std::vector<mavlink::ParamValue> mass = answers(named("MASS_KG"), 1);
  ASSERT_EQ(mass.size(), 1U);
  EXPECT_EQ(mass[0].param_value, static_cast<float>(vehicle.translation.mass_kg));
  const std::vector<mavlink::ParamValue> first = answers(mavlink::ParamRequestRead{.param_index = 0}, 1);
  ASSERT_EQ(first.size(), 1U);
  EXPECT_EQ(first[0].param_value, static_cast<float>(config.fence.side[0].low_m));
  EXPECT_TRUE(answers(named("MASS"), 1).empty());
  EXPECT_TRUE(answers(named("MASS_KG_AND_MORE"), 1).empty());
  EXPECT_TRUE(answers(mavlink::ParamRequestRead{.param_index = 1000}, 1).empty());
}

// Would catch a program that changes a parameter in flight, and one that leaves the sender without an answer.
TEST_F(ParametersTest, AWishToChangeOneIsAnsweredWithTheValueThatStays) {
  mavlink::ParamSet wish{.param_value = 99.F, .param_type = 9};
  std::ranges::copy(std::string_view("MASS_KG"), wish.param_id.begin());
  for (int twice = 0; twice < 2; ++twice) {
    const std::vector<mavlink::ParamValue> answered = answers(wish, 1);
    ASSERT_EQ(answered.size(), 1U);
    EXPECT_EQ(answered[0].param_value, static_cast<float>(vehicle.translation.mass_kg));
  }
  EXPECT_EQ(name_of(wish), "MASS_KG");
  wish.param_id = {'\x1b', '[', '2', 'J'};
  EXPECT_TRUE(answers(wish, 1).empty());
  EXPECT_EQ(name_of(wish), "of unknown name") << "what a sender writes does not reach the terminal";
}

}  // namespace
}  // namespace m100::companion
