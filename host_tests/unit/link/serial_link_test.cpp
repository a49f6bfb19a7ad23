// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/link/serial_link.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <limits>
#include <span>
#include <vector>

#include "firmware/link/release_sequence.h"
#include "host_tests/sim/ports/link_bench.h"
#include "protocol/dji/command_decoder.h"
#include "protocol/dji/frame_encoder.h"
#include "protocol/dji/frame_parser.h"

namespace m100::link {
namespace {

using safety::AuthorityReason;
using safety::AuthorityStage;
using sim::LinkBench;
using sim::N1EventKind;
using std::chrono::milliseconds;
using std::chrono::seconds;

class BothChannels : public ::testing::TestWithParam<Channel> {};
INSTANTIATE_TEST_SUITE_P(SerialLink, BothChannels, ::testing::Values(Channel::kVirtualRc, Channel::kMovement),
                         [](const auto& tested) {
                           return tested.param == Channel::kVirtualRc ? "VirtualRc" : "Movement";
                         });

TEST_P(BothChannels, StartUpRunsByItselfAndStopsBeforeAskingForControl) {
  LinkBench bench(LinkBench::over(GetParam()));
  ASSERT_TRUE(bench.run_until(AuthorityStage::kReady, seconds(3)));
  EXPECT_TRUE(bench.autopilot.activated());
  bench.run(seconds(10));
  EXPECT_EQ(bench.link.authority().stage, AuthorityStage::kReady);
  EXPECT_EQ(bench.autopilot.record().obtain_requests, 0U) << "nobody asked";
  EXPECT_EQ(bench.autopilot.record().virtual_rc_on_requests, 0U);
  EXPECT_NEAR(bench.link.health().telemetry_rate_hz, 100.0, 1.0);
}

TEST_P(BothChannels, FromStartUpToRelease) {
  RecordProperty("promise", "R4");
  LinkBench bench(LinkBench::over(GetParam()));
  ASSERT_TRUE(bench.take_control());
  EXPECT_EQ(bench.autopilot.record().obtain_requests, 2U);
  EXPECT_GE(bench.autopilot.record().min_obtain_spacing, seconds(2) - sim::N1Autopilot::kTick);
  const std::size_t before = bench.sent_at.size();
  bench.run(seconds(10));
  const double rate_hz = GetParam() == Channel::kVirtualRc ? 25.0 : 50.0;
  EXPECT_NEAR(static_cast<double>(bench.sent_at.size() - before), 10.0 * rate_hz, 1.0);
  EXPECT_EQ(bench.autopilot.record().virtual_rc_ignored + bench.autopilot.record().movement_ignored, 0U);
  EXPECT_LE(bench.autopilot.record().max_commands_per_s, static_cast<std::uint32_t>(rate_hz) + 1U);
  EXPECT_EQ(bench.link.health().commands_sent, bench.sent_at.size());
  EXPECT_EQ(bench.link.health().commands_dropped, 0U);
  EXPECT_GT(bench.link.health().parser.frames, 1000U);
  bench.link.release(bench.clock.now());
  ASSERT_TRUE(bench.run_until(AuthorityStage::kReady, seconds(3)));
  EXPECT_EQ(bench.link.authority().reason, AuthorityReason::kReleased);
  EXPECT_FALSE(bench.autopilot.client_in_control());
  EXPECT_FALSE(bench.autopilot.virtual_rc_on());
  EXPECT_EQ(bench.last_status, core::Status::kRefused);
  const std::uint32_t refused = bench.link.health().commands_refused;
  EXPECT_EQ(bench.link.send(bench.command(), bench.clock.now()), core::Status::kRefused);
  EXPECT_EQ(bench.link.health().commands_refused, refused + 1);
}

// Catches a state that is true from the beginning, or that another item makes true.
TEST(SerialLinkTest, TheViewSaysNothingBeforeItIsSo) {
  LinkBench bench({});
  const AuthorityView& view = bench.link.authority();
  for (int tick = 0; tick < 2; ++tick) {
    EXPECT_FALSE(view.in_control || view.mode_f || view.control_requested || view.release_pending || view.port_gone ||
                 view.link_alive || view.telemetry_fresh || bench.link.due(bench.clock.now()));
    (void)bench.link.receive(bench.clock.now());
  }
  ASSERT_TRUE(bench.run_until(AuthorityStage::kReady));
  EXPECT_TRUE(view.mode_f && view.link_alive && view.telemetry_fresh);
  EXPECT_FALSE(view.control_requested || view.port_gone);
  LinkBench early({});
  early.link.request_control(early.clock.now());
  early.tick();
  EXPECT_TRUE(early.link.authority().control_requested) << "until start-up is over";
  bench.cable().set_plugged(false);
  for (int tick = 0; tick < 600; ++tick) {
    bench.clock.advance(milliseconds(1));
    (void)bench.link.receive(bench.clock.now());
    const core::Duration age = bench.clock.now() - bench.link.received_at(protocol::TelemetryItem::kTime);
    EXPECT_EQ(view.telemetry_fresh, age <= milliseconds(100)) << tick;
    EXPECT_EQ(view.link_alive, age <= milliseconds(500)) << tick;
    EXPECT_TRUE(view.port_gone);
  }
}

struct Loss {
  const char* name;
  N1EventKind what;
  double value;
  AuthorityReason reason;
  AuthorityStage stage;
};

class EveryLoss : public ::testing::TestWithParam<std::tuple<Loss, Channel>> {};
INSTANTIATE_TEST_SUITE_P(
    SerialLink, EveryLoss,
    ::testing::Combine(
        ::testing::Values(
            Loss{"SwitchToA", N1EventKind::kMode, 'A', AuthorityReason::kControlLost, AuthorityStage::kSilent},
            Loss{"SwitchToP", N1EventKind::kMode, 'P', AuthorityReason::kControlLost, AuthorityStage::kSilent},
            Loss{"MobileApp", N1EventKind::kTake, 'm', AuthorityReason::kControlLost, AuthorityStage::kSilent},
            Loss{"RcOff", N1EventKind::kRc, 0, AuthorityReason::kControlLost, AuthorityStage::kSilent},
            Loss{"Restart", N1EventKind::kRestart, 0, AuthorityReason::kLinkSilent, AuthorityStage::kSilentCold},
            Loss{"Silence", N1EventKind::kSilence, 5, AuthorityReason::kLinkSilent, AuthorityStage::kSilentCold}),
        ::testing::Values(Channel::kVirtualRc, Channel::kMovement)),
    [](const auto& tested) {
      return std::string(std::get<0>(tested.param).name) +
             (std::get<1>(tested.param) == Channel::kVirtualRc ? "VirtualRc" : "Movement");
    });

// Catches a client that continues to send, one that asks again by itself, and one that can never return to control.
TEST_P(EveryLoss, StopsWithinAPeriodAndStaysSilentUntilTheOperatorAsks) {
  RecordProperty("promise", "R4");
  const auto& [loss, channel] = GetParam();
  LinkBench bench(LinkBench::over(channel));
  ASSERT_TRUE(bench.take_control());
  bench.run(seconds(3));
  bench.autopilot.happen(loss.what, loss.value);
  const core::TimePoint lost_at = bench.clock.now();
  ASSERT_TRUE(bench.run_until(loss.stage, seconds(1)));
  EXPECT_EQ(bench.link.authority().reason, loss.reason) << safety::name(bench.link.authority().reason);
  bench.run(seconds(5));
  EXPECT_EQ(bench.link.health().restarts, loss.what == N1EventKind::kRestart ? 1U : 0U);
  // A restarted or silent autopilot is noticed only by its silence, for which the promise allows 500 ms.
  const bool by_silence = loss.reason == AuthorityReason::kLinkSilent;
  const core::Duration allowed =
      by_silence ? SerialLink::kLinkTimeout + bench.link.command_period() : bench.link.command_period();
  EXPECT_LE((bench.sent_at.back() - lost_at).count(), allowed.count());
  if (!by_silence) {
    EXPECT_LE(bench.autopilot.record().latest_after_loss.count(), bench.link.command_period().count());
  }
  const std::uint64_t bytes_before = bench.link.health().bytes_sent;
  const std::uint32_t requests_before = bench.autopilot.record().obtain_requests;
  // The cause is gone, but nobody has asked for control.
  bench.autopilot.set_mode(sim::N1Mode::kF);
  bench.autopilot.happen(N1EventKind::kTake, 'r');
  bench.autopilot.happen(N1EventKind::kRc, 1);
  bench.run(seconds(10));
  EXPECT_EQ(bench.link.health().bytes_sent, bytes_before) << "not one byte";
  EXPECT_EQ(bench.autopilot.record().obtain_requests, requests_before);
  bench.link.request_control(bench.clock.now());
  EXPECT_TRUE(bench.run_until(AuthorityStage::kInControl));
  EXPECT_GE(bench.autopilot.record().min_obtain_spacing.count(), 2000000 - 2500);
  EXPECT_GE(bench.autopilot.record().min_on_spacing.count(), 2000000 - 2500);
}

/// Switches Virtual RC on twice: a second "on" makes the autopilot ignore its mode switch (protocol, 7).
void make_deaf_to_its_switch(LinkBench& bench) {
  const protocol::VirtualRcSwitch on{.on = true, .fall_back_to_rc = true, .reserved = 0};
  const protocol::MessageId id = id_of(on);
  std::array<std::byte, protocol::kMaxFrameBytes> space;
  const core::Expected<protocol::Value> value = encode(on);
  for (std::uint16_t sequence = 1; sequence <= 2; ++sequence) {
    const auto frame = protocol::encode_frame({.sequence = sequence}, &id, *value, space, nullptr);
    ASSERT_EQ(bench.cable().a().write(*frame).value(), frame->size());
  }
}

class RcItem : public ::testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(SerialLink, RcItem, ::testing::Values(true, false),
                         [](const auto& tested) { return tested.param ? "ShowsVirtualRc" : "ShowsTheTransmitter"; });

/// Moves the mode switch in a stage. Six seconds later the client must not command, and after the move it may have
/// commanded for at most one period.
void expect_taken_back(const LinkBench::Options& options, AuthorityStage stage, char mode) {
  SCOPED_TRACE(std::string(safety::name(stage)) + " " + mode);
  LinkBench bench(options);
  ASSERT_TRUE(bench.run_until(AuthorityStage::kReady));
  bench.link.request_control(bench.clock.now());
  if (stage == AuthorityStage::kReleasing) {
    ASSERT_TRUE(bench.run_until(AuthorityStage::kInControl));
    bench.run(seconds(1));
    bench.link.release(bench.clock.now());
  }
  ASSERT_TRUE(stage == AuthorityStage::kReady || bench.run_until(stage));
  bench.autopilot.happen(N1EventKind::kMode, mode);
  const core::TimePoint moved_at = bench.clock.now();
  bench.run(seconds(6));
  EXPECT_FALSE(bench.autopilot.client_in_control());
  EXPECT_FALSE(bench.autopilot.virtual_rc_on());
  EXPECT_FALSE(bench.link.authority().in_control);
  if (!bench.sent_at.empty()) {
    EXPECT_LE((bench.sent_at.back() - moved_at).count(), bench.link.command_period().count());
  }
  EXPECT_LE(bench.autopilot.record().latest_after_loss.count(), bench.link.command_period().count());
}

// The pilot's switch works in every stage on the way to control and back, with either kind of RC item.
TEST_P(RcItem, TheModeSwitchTakesTheAircraftBackInEveryStage) {
  RecordProperty("promise", "R4");
  for (const Channel channel : {Channel::kVirtualRc, Channel::kMovement}) {
    for (const AuthorityStage stage :
         {AuthorityStage::kReady, AuthorityStage::kObtaining, AuthorityStage::kSpacing, AuthorityStage::kConfirming,
          AuthorityStage::kEnabling, AuthorityStage::kInControl, AuthorityStage::kReleasing}) {
      if (stage == AuthorityStage::kEnabling && channel == Channel::kMovement) {
        continue;  // movement control has no enabling stage
      }
      LinkBench::Options options = LinkBench::over(channel);
      options.autopilot.behaviour.virtual_rc.shown_in_rc_item = GetParam();
      for (const char mode : {'A', 'P'}) {
        ASSERT_NO_FATAL_FAILURE(expect_taken_back(options, stage, mode));
      }
    }
  }
}

// Catches a client that looks only at its own mode channel: an autopilot that ignores its switch reports nothing else.
// Where the RC item shows the transmitter, the switch is seen all the same.
TEST(SerialLinkTest, TheModeSwitchIsSeenEvenIfTheAutopilotIgnoresIt) {
  RecordProperty("promise", "R4");
  LinkBench::Options options = LinkBench::over(Channel::kVirtualRc);
  options.autopilot.behaviour.virtual_rc.shown_in_rc_item = false;
  LinkBench bench(options);
  ASSERT_TRUE(bench.take_control());
  bench.run(seconds(3));
  make_deaf_to_its_switch(bench);
  bench.run(milliseconds(50));
  ASSERT_TRUE(bench.link.authority().in_control);
  bench.autopilot.set_mode(sim::N1Mode::kA);
  const core::TimePoint moved_at = bench.clock.now();
  bench.run(seconds(1));
  EXPECT_EQ(bench.link.authority().reason, AuthorityReason::kLeftModeF) << safety::name(bench.link.authority().reason);
  EXPECT_LE((bench.sent_at.back() - moved_at).count(), bench.link.command_period().count());
}

// Without the item that shows the switch, or the one that shows who controls, nothing shows a loss of control.
TEST(SerialLinkTest, WithoutTheItemsThatShowControlNoneIsTaken) {
  for (const protocol::TelemetryItem item : {protocol::TelemetryItem::kRc, protocol::TelemetryItem::kControl}) {
    LinkBench::Options options;
    options.link.rates[static_cast<std::size_t>(std::countr_zero(static_cast<unsigned>(item)))] = protocol::Rate::kOff;
    LinkBench bench(options);
    EXPECT_FALSE(bench.take_control());
    EXPECT_FALSE(bench.autopilot.client_in_control());
  }
}

TEST(SerialLinkTest, ARefusedAskNamesTheRemedyAndIsNotRepeated) {
  LinkBench::Options options;
  options.autopilot.mode = sim::N1Mode::kP;
  LinkBench bench(options);
  ASSERT_TRUE(bench.run_until(AuthorityStage::kReady));
  bench.link.request_control(bench.clock.now());
  bench.run(seconds(5));
  EXPECT_EQ(bench.link.authority().reason, AuthorityReason::kNotModeF);
  EXPECT_NE(safety::remedy(bench.link.authority().reason).find('F'), std::string_view::npos);
  bench.autopilot.set_mode(sim::N1Mode::kF);
  bench.run(seconds(5));
  EXPECT_EQ(bench.autopilot.record().obtain_requests, 0U);
}

TEST(SerialLinkTest, EndlessObtainingEndsAfterThreeRequests) {
  RecordProperty("promise", "R4");
  LinkBench bench({});
  ASSERT_TRUE(bench.run_until(AuthorityStage::kReady));
  bench.autopilot.happen(N1EventKind::kTake, 'm');
  bench.link.request_control(bench.clock.now());
  ASSERT_TRUE(bench.run_until(AuthorityStage::kSilent));
  EXPECT_EQ(bench.autopilot.record().obtain_requests, 3U);
  EXPECT_EQ(bench.link.authority().reason, AuthorityReason::kEndlessObtaining);
  bench.run(seconds(20));
  EXPECT_EQ(bench.autopilot.record().obtain_requests, 3U);
}

TEST(SerialLinkTest, AnAnswerToActivationStopsOrRetriesSlowlyAndSaysWhy) {
  for (int code = 1; code <= 8; ++code) {
    SCOPED_TRACE(code);
    const bool is_tried_again = (code >= 3 && code <= 5) || code == 8;  // new device, no app, no internet; version
    LinkBench bench({});
    bench.autopilot.happen(N1EventKind::kActivation, code);
    ASSERT_TRUE(bench.run_until(is_tried_again ? AuthorityStage::kPausing : AuthorityStage::kSilentCold, seconds(3)));
    EXPECT_EQ(bench.link.authority().reason, AuthorityReason::kAnswer);
    EXPECT_EQ(bench.link.authority().answer.code, code);
    EXPECT_FALSE(bench.link.authority().answer.remedy.empty());
    bench.autopilot.happen(N1EventKind::kActivation, 0);
    EXPECT_EQ(bench.run_until(AuthorityStage::kReady, seconds(10)), is_tried_again);
  }
}

TEST(SerialLinkTest, LostLateAndDoubledAcknowledgementsOnlyCostTime) {
  for (const N1EventKind what : {N1EventKind::kLoseAcks, N1EventKind::kDoubleAcks}) {
    for (int count = 1; count <= 2; ++count) {
      LinkBench bench({});
      bench.autopilot.happen(what, count);
      EXPECT_TRUE(bench.take_control()) << count;
      EXPECT_LE(bench.autopilot.record().obtain_requests, 3U);
    }
  }
  LinkBench late({});
  late.autopilot.happen(N1EventKind::kDelayAcks, 0.09);
  EXPECT_TRUE(late.take_control());
  EXPECT_GE(late.autopilot.record().min_obtain_spacing.count(), 2000000 - 2500);
}

TEST(SerialLinkTest, ALostAnswerToAnObtainRequestIsMadeGoodByTheNextRequest) {
  LinkBench bench({});
  ASSERT_TRUE(bench.run_until(AuthorityStage::kReady));
  bench.autopilot.happen(N1EventKind::kLoseAcks, 1);
  bench.link.request_control(bench.clock.now());
  ASSERT_TRUE(bench.run_until(AuthorityStage::kInControl));
  EXPECT_EQ(bench.autopilot.record().obtain_requests, 2U);
  EXPECT_GE(bench.autopilot.record().min_obtain_spacing.count(), 2000000 - 2500);
}

// Catches a link that continues where it was when the port returns: another autopilot may be connected.
TEST(SerialLinkTest, PluggedInAgainItBecomesReadyAndAsksNobodyForControl) {
  RecordProperty("promise", "R4");
  for (const bool in_flight : {true, false}) {
    LinkBench bench({});
    ASSERT_TRUE(in_flight ? bench.take_control() : bench.run_until(AuthorityStage::kReady));
    const std::uint32_t requests = bench.autopilot.record().obtain_requests;
    bench.cable().set_plugged(false);
    bench.run(milliseconds(200));                   // shorter than the silence that ends control
    bench.link.request_control(bench.clock.now());  // meant for the previous autopilot
    bench.cable().set_plugged(true);
    (void)bench.link.receive(bench.clock.now());
    EXPECT_FALSE(bench.link.authority().link_alive || bench.link.version().version_crc != 0) << "nobody has spoken yet";
    bench.run(milliseconds(30));
    EXPECT_FALSE(bench.link.authority().in_control);
    EXPECT_EQ(bench.link.health().outages, 1U);
    EXPECT_TRUE(bench.run_until(AuthorityStage::kReady));
    bench.run(seconds(5));
    EXPECT_EQ(bench.link.authority().stage, AuthorityStage::kReady);
    EXPECT_FALSE(bench.link.authority().release_pending);
    EXPECT_TRUE(bench.autopilot.transmitter_in_control());
    EXPECT_EQ(bench.autopilot.record().obtain_requests, requests);
    bench.link.request_control(bench.clock.now());
    EXPECT_TRUE(bench.run_until(AuthorityStage::kInControl));
  }
}

// On the movement channel telemetry says "ours" for ever, even if our bytes do not arrive; only an answer shows the
// loss.
TEST(SerialLinkTest, BytesOfOursThatDoNotArriveAreNoticedWithinASecond) {
  RecordProperty("promise", "R15");
  for (const Channel channel : {Channel::kMovement, Channel::kVirtualRc}) {
    LinkBench bench(LinkBench::over(channel));
    ASSERT_TRUE(bench.take_control());
    const std::uint32_t requests = bench.link.health().sessions.requests;
    bench.run(seconds(10));
    EXPECT_EQ(bench.link.health().sessions.requests - requests, 47U) << "an answer later than a fifth of a second each";
    EXPECT_EQ(bench.link.authority().stage, AuthorityStage::kInControl) << "healthy is silent";
    bench.cable().a_to_b().set_faults({.drop_per_write = 1.0});
    ASSERT_TRUE(
        bench.run_until(AuthorityStage::kSilent, milliseconds(1050)));  // 0.2 s, eight times 0.1 s, and the tick
    EXPECT_EQ(bench.link.authority().reason, AuthorityReason::kUplinkSilent);
    EXPECT_TRUE(bench.link.authority().release_pending);
    bench.run(seconds(3));
    bench.cable().a_to_b().set_faults({});
    bench.run(seconds(1));
    EXPECT_TRUE(bench.autopilot.transmitter_in_control()) << "it went on giving back";
    EXPECT_FALSE(bench.link.authority().release_pending);
    EXPECT_EQ(bench.link.authority().stage, AuthorityStage::kSilent);
  }
}

// Catches a queue of commands on a blocked line: they would all be sent, outdated, when it is free again.
TEST(SerialLinkTest, AStuckLineKeepsNoStaleCommands) {
  RecordProperty("promise", "R4");
  for (const Channel channel : {Channel::kMovement, Channel::kVirtualRc}) {
    for (const sim::N1Mode mode : {sim::N1Mode::kF, sim::N1Mode::kP}) {
      LinkBench bench(LinkBench::over(channel));
      ASSERT_TRUE(bench.take_control());
      bench.run(seconds(1));
      bench.cable().a_to_b().set_faults({.longest_write = 0});
      bench.run(milliseconds(250));
      bench.autopilot.set_mode(mode);
      bench.run(milliseconds(50));
      bench.cable().a_to_b().set_faults({});
      const auto& record = bench.autopilot.record();
      const std::uint32_t before = record.movement_taken + record.virtual_rc_taken;
      bench.run(milliseconds(20));
      EXPECT_LE(record.movement_taken + record.virtual_rc_taken, before + 2);
      EXPECT_EQ(record.latest_after_loss, core::Duration{0}) << "none after control was lost";
      EXPECT_GE(bench.link.health().commands_dropped, 5U);
      EXPECT_LE(bench.link.health().commands_dropped, 15U);
    }
  }
}

TEST(SerialLinkTest, ShortWritesAndOneByteReadsChangeNothing) {
  LinkBench bench(LinkBench::over(Channel::kMovement));
  bench.cable().a_to_b().set_faults({.longest_write = 7});
  ASSERT_TRUE(bench.take_control());
  bench.run(seconds(5));
  EXPECT_EQ(bench.autopilot.parser_stats().crc32_errors, 0U);
  EXPECT_EQ(bench.autopilot.parser_stats().bytes_dropped, 0U);
  EXPECT_GT(bench.autopilot.record().movement_taken, 50U);
}

TEST(SerialLinkTest, NumbersOutOfRangeNeverLeave) {
  RecordProperty("promise", "R5");
  LinkBench bench(LinkBench::over(Channel::kMovement));
  ASSERT_TRUE(bench.take_control());
  bench.commanding = false;
  bench.run(milliseconds(100));
  ctl::Command<double> command;
  command.roll_rad = std::numeric_limits<double>::quiet_NaN();
  const std::uint32_t refused = bench.link.health().commands_refused;
  EXPECT_EQ(bench.link.send(command, bench.clock.now()), core::Status::kOutOfRange);
  EXPECT_EQ(bench.link.health().commands_refused, refused + 1);
  command.roll_rad = 10.0;
  EXPECT_EQ(bench.link.send(command, bench.clock.now()), core::Status::kOk);
  bench.run(milliseconds(20));
  const auto* flown = std::get_if<sim::MovementInput>(&bench.vehicle.last_input());
  ASSERT_NE(flown, nullptr);
  EXPECT_NEAR(flown->roll_rad, 30.0 / 57.29577951, 1e-6) << "saturated at 30 degrees";
}

TEST(SerialLinkTest, SticksOutsideTheirTravelNeverLeave) {
  RecordProperty("promise", "R5");
  LinkBench bench(LinkBench::over(Channel::kVirtualRc));
  ASSERT_TRUE(bench.take_control());
  bench.commanding = false;
  bench.run(milliseconds(100));
  vrc::Sticks sticks;
  sticks.roll = vrc::Stick{1685};
  EXPECT_EQ(bench.link.send(sticks, bench.clock.now()), core::Status::kOutOfRange);
  EXPECT_EQ(bench.link.send(ctl::Command<double>{}, bench.clock.now()), core::Status::kInvalidArgument);
}

/// The kinds of the commands in these bytes.
std::vector<std::size_t> kinds_of(std::span<const std::byte> bytes) {
  std::vector<std::size_t> kinds;
  int backs = 0;
  protocol::FrameParser parser;
  parser.consume(bytes, [&](const protocol::FrameView& frame) {
    const protocol::MessageId id{static_cast<std::uint8_t>(frame.data[0]), static_cast<std::uint8_t>(frame.data[1])};
    const core::Expected<protocol::Command> command = decode_command(id, frame.data.subspan(2));
    ASSERT_TRUE(command);
    const bool is_back = std::holds_alternative<protocol::ControlRequest>(*command);
    EXPECT_EQ(frame.header.session, is_back ? 30 + backs++ : 0) << "of those that the link does not use";
    kinds.push_back(command->index());
    const auto* const off = std::get_if<protocol::VirtualRcSwitch>(&*command);
    EXPECT_TRUE(off == nullptr || (!off->on && off->fall_back_to_rc && off->reserved == 0));
  });
  EXPECT_EQ(parser.stats().bytes_dropped, 0U);
  return kinds;
}

// Neutral sticks or movement, Virtual RC off where it is on, and control given back twice.
TEST(SerialLinkTest, TheFarewellIsTheseCommandsInThisOrder) {
  const std::size_t back = protocol::Command(protocol::ControlRequest{}).index();
  const std::size_t off = protocol::Command(protocol::VirtualRcSwitch{}).index();
  const ReleaseSequence sticks(vrc::Sticks{}, nullptr), movement(ctl::Command<double>{}, nullptr);
  EXPECT_EQ(kinds_of(sticks.release_only()), (std::vector{off, back, back}));
  EXPECT_EQ(kinds_of(movement.release_only()), (std::vector{back, back}));
  EXPECT_EQ(kinds_of(sticks.bytes()),
            (std::vector{protocol::Command(protocol::VirtualRcData{}).index(), off, back, back}));
  EXPECT_EQ(kinds_of(movement.bytes()), (std::vector{protocol::Command(protocol::Movement{}).index(), back, back}));
}

// Catches a release sequence that the autopilot does not accept: wrong session, stored answer, only one request.
TEST(SerialLinkTest, TheFarewellGivesControlBackWithoutTheLink) {
  for (const Channel channel : {Channel::kVirtualRc, Channel::kMovement}) {
    LinkBench bench(LinkBench::over(channel));
    const ReleaseSequence release_sequence(bench.command(), nullptr);
    ASSERT_TRUE(bench.take_control());
    ASSERT_EQ(bench.cable().a().write(release_sequence.bytes()).value(), release_sequence.bytes().size());
    for (int i = 0; i < 10; ++i) {
      bench.clock.advance(sim::N1Autopilot::kTick);
      bench.autopilot.advance(bench.clock.now());
    }
    EXPECT_FALSE(bench.autopilot.client_in_control());
    EXPECT_FALSE(bench.autopilot.virtual_rc_on());
  }
}

TEST(SerialLinkTest, TheAutopilotsClockIsWatched) {
  LinkBench bench({});
  ASSERT_TRUE(bench.take_control());
  bench.run(seconds(2));
  EXPECT_EQ(bench.link.health().restarts, 0U);
  std::uint32_t jitters = 0;
  for (const std::uint32_t count : bench.link.health().jitter_histogram) {
    jitters += count;
  }
  EXPECT_GT(jitters, 400U);
  EXPECT_LT(bench.link.health().longest_gap, milliseconds(50));
  EXPECT_NEAR(bench.link.health().receive_share, 0.43, 0.05);  // 97 bytes at 100 Hz and position at 10 Hz
}

// Catches an age that belongs to another item: items that come at 100 Hz never grow older than two ticks; the position,
// which comes at 10 Hz, does.
TEST(SerialLinkTest, EveryItemHasAnAgeOfItsOwn) {
  using protocol::TelemetryItem;
  LinkBench bench({});
  ASSERT_TRUE(bench.run_until(AuthorityStage::kReady));
  bench.run(seconds(1));
  core::Duration oldest_attitude{0};
  core::Duration oldest_position{0};
  for (int i = 0; i < 100; ++i) {
    bench.tick();
    const auto age = [&bench](TelemetryItem item) { return bench.clock.now() - bench.link.received_at(item); };
    oldest_attitude = std::max(oldest_attitude, age(TelemetryItem::kAttitude));
    oldest_position = std::max(oldest_position, age(TelemetryItem::kPosition));
  }
  EXPECT_LE(oldest_attitude, milliseconds(20));
  EXPECT_GE(oldest_position, milliseconds(80));
  EXPECT_LE(oldest_position, milliseconds(110));
}

}  // namespace
}  // namespace m100::link
