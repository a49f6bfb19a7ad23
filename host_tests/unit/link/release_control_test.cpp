// SPDX-License-Identifier: BSD-3-Clause
// The pilot gets the sticks back (promise R15). The test looks at the autopilot: which device controls it, and since
// when.
#include <gtest/gtest.h>

#include <optional>
#include <variant>
#include <vector>

#include "host_tests/sim/ports/link_bench.h"
#include "protocol/dji/command_decoder.h"
#include "protocol/dji/commands.h"
#include "protocol/dji/frame_parser.h"

namespace m100::link {
namespace {

using safety::AuthorityReason;
using safety::AuthorityStage;
using sim::LinkBench;
using sim::N1EventKind;
using std::chrono::milliseconds;
using std::chrono::seconds;

class ReleaseControl : public ::testing::TestWithParam<Channel> {
 protected:
  static LinkBench::Options options() { return LinkBench::over(GetParam()); }
  static bool is_pilots(const LinkBench& bench) {
    return !bench.autopilot.client_in_control() && !bench.autopilot.virtual_rc_on();
  }
  /// @returns the time until the pilot has control; empty: not within two seconds.
  static std::optional<core::Duration> time_to_the_pilot(LinkBench& bench) {
    const core::TimePoint from = bench.clock.now();
    return bench.run_until([&] { return is_pilots(bench); }, seconds(2))
               ? std::optional<core::Duration>(bench.clock.now() - from)
               : std::nullopt;
  }
};
INSTANTIATE_TEST_SUITE_P(Link, ReleaseControl, ::testing::Values(Channel::kVirtualRc, Channel::kMovement),
                         [](const auto& tested) {
                           return tested.param == Channel::kVirtualRc ? "VirtualRc" : "Movement";
                         });

// Catches a client that relies on the answer "again" or on its own request instead of telemetry.
TEST_P(ReleaseControl, AReleasedAircraftIsThePilotsAlthoughEveryAnswerIsLost) {
  RecordProperty("promise", "R15");
  LinkBench bench(options());
  ASSERT_TRUE(bench.take_control());
  bench.run(seconds(2));
  bench.autopilot.happen(N1EventKind::kLoseAcks, 1000);
  bench.run(milliseconds(250));  // the query whether our bytes arrive is open
  bench.link.release(bench.clock.now());
  bench.tick();
  const std::uint32_t repeats = bench.link.health().sessions.repeats;
  const auto taken = time_to_the_pilot(bench);
  ASSERT_TRUE(taken.has_value());
  EXPECT_LE(*taken, milliseconds(190)) << "two requests, a tenth of a second apart";
  ASSERT_TRUE(bench.run_until(AuthorityStage::kReady, milliseconds(200)));
  EXPECT_EQ(bench.link.authority().reason, AuthorityReason::kReleased);
  EXPECT_FALSE(bench.link.authority().release_pending);
  EXPECT_EQ(bench.link.health().sessions.repeats, repeats) << "what was asked in control is not asked any longer";
}

/// Keeps the switches of Virtual RC that were sent.
struct SentSwitches final : ByteTap {
  void received(std::span<const std::byte>, core::TimePoint) override {}
  void sent(std::span<const std::byte> bytes, core::TimePoint) override {
    parser.consume(bytes, [this](const protocol::FrameView& frame) {
      if (frame.header.is_ack || frame.data.size() < 2) {
        return;
      }
      const protocol::MessageId id{static_cast<std::uint8_t>(frame.data[0]), static_cast<std::uint8_t>(frame.data[1])};
      const core::Expected<protocol::Command> command = decode_command(id, frame.data.subspan(2));
      if (command) {
        if (const auto* const turned = std::get_if<protocol::VirtualRcSwitch>(&*command)) {
          switches.push_back(*turned);
        }
        const auto* const made = std::get_if<protocol::Activation>(&*command);
        activation = made != nullptr ? *made : activation;
      }
    });
  }
  protocol::FrameParser parser;
  std::vector<protocol::VirtualRcSwitch> switches;
  protocol::Activation activation{};
};

// The emulated autopilot looks at `on` alone. The real one also looks at what follows it: without fall_back_to_rc it
// would fly its fail-safe for a lost transmitter.
TEST(GivingBackOnTheWire, VirtualRcIsSwitchedOffAndFallsBackToTheTransmitter) {
  SentSwitches sent;
  LinkBench::Options options = LinkBench::over(Channel::kVirtualRc);
  options.tap = &sent;
  LinkBench bench(options);
  ASSERT_TRUE(bench.take_control());
  ASSERT_FALSE(sent.switches.empty());
  EXPECT_TRUE(sent.switches.back().on);
  EXPECT_EQ(sent.activation.api_level, 2U);
  EXPECT_EQ(std::string(sent.activation.bundle_id.begin(), sent.activation.bundle_id.end()), std::string(32, '9'));
  sent.switches.clear();
  bench.link.release(bench.clock.now());
  bench.run(seconds(1));
  ASSERT_FALSE(sent.switches.empty());
  for (const protocol::VirtualRcSwitch& off : sent.switches) {
    EXPECT_FALSE(off.on);
    EXPECT_TRUE(off.fall_back_to_rc);
    EXPECT_EQ(off.reserved, 0);
  }
}

TEST_P(ReleaseControl, ItIsNotFinishedBeforeTelemetrySaysSo) {
  RecordProperty("promise", "R15");
  LinkBench bench(options());
  ASSERT_TRUE(bench.take_control());
  bench.run(seconds(2));
  bench.cable().a_to_b().set_faults({.drop_per_write = 1.0});  // none of our bytes arrives
  bench.link.release(bench.clock.now());
  bench.run(seconds(3));
  EXPECT_EQ(bench.link.authority().stage, AuthorityStage::kReleasing);
  EXPECT_TRUE(bench.link.authority().release_pending);
  bench.cable().a_to_b().set_faults({});
  const auto taken = time_to_the_pilot(bench);
  ASSERT_TRUE(taken.has_value()) << "it went on trying";
  EXPECT_LE(*taken, milliseconds(500));
}

// Every acknowledgement is lost, but telemetry shows that the requested control was granted.
TEST_P(ReleaseControl, AGrantWhoseAcknowledgementIsLostIsSeen) {
  RecordProperty("promise", "R15");
  LinkBench bench(options());
  ASSERT_TRUE(bench.run_until(AuthorityStage::kReady));
  bench.autopilot.happen(N1EventKind::kLoseAcks, 1000);
  bench.link.request_control(bench.clock.now());
  EXPECT_TRUE(bench.run_until(AuthorityStage::kInControl, seconds(8)));
  bench.link.release(bench.clock.now());
  EXPECT_TRUE(time_to_the_pilot(bench).has_value());
}

// The operator stops at any moment of the request; control that is granted all the same must be given back.
TEST_P(ReleaseControl, AStopWhileAskingLeavesNothingHeld) {
  RecordProperty("promise", "R15");
  for (int wait_ms = 0; wait_ms < 2600; wait_ms += 130) {
    SCOPED_TRACE(wait_ms);
    LinkBench bench(options());
    ASSERT_TRUE(bench.run_until(AuthorityStage::kReady));
    bench.autopilot.happen(N1EventKind::kDelayAcks, 0.12);
    bench.link.request_control(bench.clock.now());
    bench.run(milliseconds(wait_ms));
    bench.link.release(bench.clock.now());
    bench.run(seconds(1));
    EXPECT_TRUE(is_pilots(bench));
    bench.run(seconds(1));
    EXPECT_FALSE(bench.link.authority().release_pending);
    EXPECT_NE(bench.link.authority().stage, AuthorityStage::kInControl);
  }
}

TEST_P(ReleaseControl, OurReceiverAloneIsDeadAndTheFarewellIsSentBlind) {
  RecordProperty("promise", "R15");
  LinkBench bench(options());
  ASSERT_TRUE(bench.take_control());
  bench.run(seconds(2));
  bench.cable().b_to_a().set_faults({.drop_per_write = 1.0});
  ASSERT_TRUE(bench.run_until(AuthorityStage::kSilentCold, milliseconds(600)));
  EXPECT_EQ(bench.link.authority().reason, AuthorityReason::kLinkSilent);
  const auto taken = time_to_the_pilot(bench);
  ASSERT_TRUE(taken.has_value());
  EXPECT_LE(*taken, milliseconds(300));
  EXPECT_TRUE(bench.link.authority().release_pending) << "nobody has said that it worked";
  const std::uint32_t requests = bench.link.health().sessions.requests;
  bench.run(seconds(5));
  EXPECT_LE(bench.link.health().sessions.requests - requests, 25U) << "at most five times a second";
  EXPECT_GE(bench.link.health().sessions.requests - requests, 20U) << "and it goes on trying";
  bench.cable().b_to_a().set_faults({});
  bench.run(milliseconds(100));
  EXPECT_FALSE(bench.link.authority().release_pending);
  EXPECT_EQ(bench.link.authority().stage, AuthorityStage::kSilentCold) << "never by itself";
}

TEST_P(ReleaseControl, WhatAProgramBeforeUsLeftIsGivenBackUnasked) {
  RecordProperty("promise", "R15");
  LinkBench bench(options());
  ASSERT_TRUE(bench.take_control());
  SerialLink second(bench.cable().a(), options().link);  // the first has died
  bool given_back = false;
  for (int i = 0; i < 100 && !given_back; ++i) {
    for (int k = 0; k < 4; ++k) {
      bench.clock.advance(sim::N1Autopilot::kTick);
      bench.autopilot.advance(bench.clock.now());
    }
    (void)second.receive(bench.clock.now());
    given_back = is_pilots(bench);
  }
  EXPECT_TRUE(given_back) << "within a second, before it was even asked to fly";
}

TEST(GivingBackVirtualRc, EndedByTheAutopilotControlGoesBackAsWell) {
  RecordProperty("promise", "R15");
  LinkBench bench({});
  ASSERT_TRUE(bench.take_control());
  bench.run(seconds(2));
  bench.autopilot.happen(N1EventKind::kEndVirtualRc);
  const core::TimePoint ended_at = bench.clock.now();
  ASSERT_TRUE(bench.run_until([&] { return !bench.autopilot.client_in_control(); }, seconds(1)));
  EXPECT_LE(bench.clock.now() - ended_at, milliseconds(300));
  EXPECT_EQ(bench.link.authority().reason, AuthorityReason::kVirtualRcEnded);
  EXPECT_LE((bench.sent_at.back() - ended_at).count(), bench.link.command_period().count());
}

// Our own program stalls for so many microseconds, and a tick, while the autopilot goes on sending.
TEST(OwnStall, LongerThanHalfASecondEndsControlAndIsCalledOurs) {
  RecordProperty("promise", "R9,R15");
  for (const Channel channel : {Channel::kVirtualRc, Channel::kMovement}) {
    for (const int stall_us : {100000, 490000, 490001, 2000000, 5000000}) {
      LinkBench bench(LinkBench::over(channel));
      ASSERT_TRUE(bench.take_control());
      bench.run(seconds(2));
      const core::TimePoint end = bench.clock.now() + core::Duration(stall_us);
      while (bench.clock.now() + sim::N1Autopilot::kTick <= end) {
        bench.clock.advance(sim::N1Autopilot::kTick);
        bench.autopilot.advance(bench.clock.now());
      }
      bench.clock.advance(end - bench.clock.now());
      const std::size_t sent = bench.sent_at.size();
      const bool ends = stall_us > 490000;
      EXPECT_EQ(bench.run_until([&] { return !bench.autopilot.client_in_control(); }, seconds(1)), ends);
      EXPECT_EQ(bench.link.authority().in_control, !ends) << safety::name(bench.link.authority().reason);
      EXPECT_EQ(bench.link.health().restarts, 0U) << "the autopilot did not restart";
      if (ends) {
        EXPECT_EQ(bench.link.authority().reason, AuthorityReason::kOwnStall)
            << safety::name(bench.link.authority().reason);
        EXPECT_EQ(bench.sent_at.size(), sent) << "no command after the stall";
      }
    }
  }
}

}  // namespace
}  // namespace m100::link
