// SPDX-License-Identifier: BSD-3-Clause
// Single faults of the whole flight controller against the emulated N1 (promise R12 and the failsafe of
// firmware/safety/PROMISES.md). Each test states the reaction and its bound.
#include <gtest/gtest.h>

#include "hal/mock/wrong_baud.h"
#include "host_tests/scenario/faults/fault_bench.h"

namespace m100::scenario {
namespace {

/// Measured largest distances from the hover point while the program commands [m], and a common margin: twice the
/// distance is a regression. The first one includes the start of control, which moves the aircraft most.
constexpr double kMargin = 2.0;
constexpr double kTaken_m = 0.122, kStalled_m = 0.035, kFlipped_m = 0.038, kDeaf_m = 0.026;

const char* label(FailsafeState failsafe_state) {
  constexpr std::array kNames{"Silent", "Nominal", "Coast", "Level", "Release"};
  return kNames[static_cast<std::size_t>(failsafe_state)];
}

struct Loss {
  const char* what;
  void (*happen)(sim::World&);
  core::Duration seen_within;  ///< time until the failsafe reacts
  bool comes_back;             ///< the switch returns to F after a second
};
const Loss kLosses[] = {
    {"SwitchToA", [](sim::World& w) { w.autopilot().set_mode(sim::N1Mode::kA); }, milliseconds(40), true},
    {"SwitchToP", [](sim::World& w) { w.autopilot().set_mode(sim::N1Mode::kP); }, milliseconds(40), true},
    {"TakenByRc", [](sim::World& w) { w.autopilot().happen(sim::N1EventKind::kTake, 'r'); }, milliseconds(40), false},
    {"TakenByApp", [](sim::World& w) { w.autopilot().happen(sim::N1EventKind::kTake, 'm'); }, milliseconds(40), false},
    {"AutopilotRestarts", [](sim::World& w) { w.autopilot().happen(sim::N1EventKind::kRestart); }, milliseconds(560),
     false},
    {"TransmitterOff", [](sim::World& w) { w.autopilot().happen(sim::N1EventKind::kRc, 0.0); }, milliseconds(40),
     false},
};

class LossInEveryFailsafeState : public ::testing::TestWithParam<std::tuple<Loss, FailsafeState, link::Channel>> {};
INSTANTIATE_TEST_SUITE_P(Faults, LossInEveryFailsafeState,
                         ::testing::Combine(::testing::ValuesIn(kLosses),
                                            ::testing::Values(FailsafeState::kSilent, FailsafeState::kNominal,
                                                              FailsafeState::kCoast, FailsafeState::kLevel,
                                                              FailsafeState::kRelease),
                                            ::testing::Values(link::Channel::kVirtualRc, link::Channel::kMovement)),
                         [](const auto& tested) {
                           return std::string(std::get<0>(tested.param).what) + label(std::get<1>(tested.param)) +
                                  (std::get<2>(tested.param) == link::Channel::kMovement ? "Movement" : "");
                         });

TEST_P(LossInEveryFailsafeState, SilencesAtOnceAndForGood) {
  RecordProperty("promise", "R4");
  const auto& [loss, failsafe_state, channel] = GetParam();
  FaultBench bench(channel);
  ASSERT_TRUE(bench.reach(failsafe_state));
  loss.happen(bench.world());
  const std::optional<core::Duration> seen = bench.until(FailsafeState::kSilent, loss.seen_within);
  EXPECT_TRUE(seen.has_value()) << "still " << label(bench.failsafe_state());
  const std::uint32_t asked = bench.noted().obtain_requests;
  bench.run(seconds(1));
  bench.world().pose_source().set_faults({});
  if (loss.comes_back) {
    bench.world().autopilot().set_mode(sim::N1Mode::kF);
  }
  for (int i = 0; i < 500; ++i) {
    bench.tick();
    ASSERT_FALSE(bench.commanding()) << "the program flies without an order";
  }
  EXPECT_EQ(bench.noted().obtain_requests, asked) << "it asked again without an order";
  EXPECT_TRUE(bench.is_sound(channel == link::Channel::kMovement ? milliseconds(20) : milliseconds(40)));
  EXPECT_LT(bench.farthest_m(), kMargin * kTaken_m);
}

// The pilot moves the mode switch during start-up and while control is requested: the program must not get control.
class SwitchDuringStartUp : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Faults, SwitchDuringStartUp, ::testing::Range(0, 300, 7));

TEST_P(SwitchDuringStartUp, EndsWithoutControl) {
  RecordProperty("promise", "R4");
  FaultBench bench;
  bool engaged = false;
  for (int i = 0; i < 1000; ++i) {
    if (i == GetParam()) {
      bench.world().autopilot().set_mode(sim::N1Mode::kP);
    }
    if (!engaged && bench.controller().link().authority().stage == safety::AuthorityStage::kReady) {
      bench.controller().engage();
      engaged = true;
    }
    bench.tick();
  }
  EXPECT_FALSE(bench.commanding());
  EXPECT_FALSE(bench.world().autopilot().client_in_control());
  EXPECT_TRUE(bench.is_sound());
}

// The motion capture repeats its last pose with advancing time stamps: the numbers look perfect.
TEST(Faults, AFrozenPoseIsNoPose) {
  RecordProperty("promise", "R12");
  FaultBench bench;
  ASSERT_TRUE(bench.take_off());
  bench.world().pose_source().set_faults({.frozen = true});
  EXPECT_TRUE(bench.until(FailsafeState::kCoast, milliseconds(120)).has_value());
  EXPECT_TRUE(bench.until(FailsafeState::kLevel, milliseconds(750)).has_value());
  EXPECT_TRUE(bench.until(FailsafeState::kRelease, milliseconds(1100)).has_value());
  EXPECT_TRUE(bench.until(FailsafeState::kSilent, milliseconds(600)).has_value());
  bench.run(seconds(1));
  EXPECT_FALSE(bench.world().autopilot().client_in_control());
  EXPECT_TRUE(bench.is_sound());
  EXPECT_LT(bench.farthest_m(), kMargin * kTaken_m);
}

// Control is granted, but no pose arrives: the failsafe stays silent, and the pilot must get the sticks back.
class ControlWithoutAPose : public ::testing::TestWithParam<link::Channel> {};
INSTANTIATE_TEST_SUITE_P(Faults, ControlWithoutAPose,
                         ::testing::Values(link::Channel::kVirtualRc, link::Channel::kMovement));

TEST_P(ControlWithoutAPose, GoesBackUnused) {
  RecordProperty("promise", "R12");
  FaultBench bench(GetParam());
  bench.run(seconds(1));
  ASSERT_EQ(bench.controller().link().authority().stage, safety::AuthorityStage::kReady);
  bench.world().pose_source().set_faults({.silent = true});
  bench.run(milliseconds(100));
  bench.controller().engage();
  bool held = false;
  for (int i = 0; i < 350; ++i) {
    bench.tick();
    ASSERT_FALSE(bench.commanding());
    held = held || bench.world().autopilot().client_in_control();
  }
  EXPECT_TRUE(held) << "control was not granted";
  EXPECT_FALSE(bench.world().autopilot().client_in_control()) << "control was not given back to the pilot";
  EXPECT_FALSE(bench.world().autopilot().virtual_rc_on());
}

// One tick in a hover is late by `late`.
struct Stall {
  core::Duration late;
  FailsafeState ends;
};
class AStall : public ::testing::TestWithParam<Stall> {};
INSTANTIATE_TEST_SUITE_P(Faults, AStall,
                         ::testing::Values(Stall{milliseconds(5), FailsafeState::kNominal},
                                           Stall{milliseconds(30), FailsafeState::kNominal},
                                           Stall{milliseconds(100), FailsafeState::kNominal},
                                           Stall{milliseconds(250), FailsafeState::kNominal},
                                           Stall{milliseconds(500), FailsafeState::kSilent},
                                           Stall{milliseconds(1000), FailsafeState::kSilent},
                                           Stall{milliseconds(2000), FailsafeState::kSilent}),
                         [](const auto& tested) { return std::to_string(tested.param.late.count() / 1000) + "ms"; });

TEST_P(AStall, IsCountedAndNoOldPoseIsFlown) {
  RecordProperty("promise", "R9,R15");
  FaultBench bench;
  ASSERT_TRUE(bench.take_off());
  bench.forget_worst();
  bench.tick(GetParam().late);
  if (GetParam().late > milliseconds(10)) {
    EXPECT_GE(bench.controller().estimate().pose_age, GetParam().late)
        << "R3: a pose that waited in a buffer is not fresh";
  }
  EXPECT_EQ(bench.controller().stats().stalls, GetParam().late > milliseconds(10) ? 1U : 0U);
  bench.run(seconds(1));
  EXPECT_EQ(bench.world().autopilot().client_in_control(), GetParam().ends == FailsafeState::kNominal)
      << "R15: within a second";
  bench.run(seconds(3));
  EXPECT_EQ(bench.failsafe_state(), GetParam().ends) << label(bench.failsafe_state());
  EXPECT_TRUE(bench.is_sound());
  EXPECT_LT(bench.farthest_m(), kMargin * kStalled_m);
}

TEST(Faults, ALogThatNobodyEmptiesDoesNotChangeTheFlight) {
  RecordProperty("promise", "R12");
  FaultBench without;
  FaultBench full(link::Channel::kVirtualRc, 1U << 14U);
  ASSERT_TRUE(without.take_off() && full.take_off());
  for (int i = 0; i < 1000; ++i) {
    without.tick();
    full.tick();
    ASSERT_EQ(without.world().vehicle().state().position_w_m, full.world().vehicle().state().position_w_m);
  }
  EXPECT_GT(full.log().dropped(), 0U);
  EXPECT_EQ(full.failsafe_state(), FailsafeState::kNominal);
}

// Bit errors in both directions, at several rates.
class BitFlips : public ::testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Faults, BitFlips, ::testing::Values(1e-6, 1e-5, 1e-4));

TEST_P(BitFlips, OnBothLinesAreNotFlown) {
  RecordProperty("promise", "R2");
  FaultBench bench;
  ASSERT_TRUE(bench.take_off());
  bench.forget_worst();
  for (hal::UartPair* const cable : {&bench.world().autopilot_line(), &bench.world().pose_line()}) {
    cable->a_to_b().set_faults({.flip_per_bit = GetParam()});
    cable->b_to_a().set_faults({.flip_per_bit = GetParam()});
  }
  bench.run(seconds(30));
  EXPECT_EQ(bench.failsafe_state(), FailsafeState::kNominal) << label(bench.failsafe_state());
  EXPECT_LT(bench.farthest_m(), kMargin * kFlipped_m);
  EXPECT_TRUE(bench.is_sound());
  EXPECT_LE(bench.oldest_pose(), milliseconds(60) + safety::Limits{}.coast);
}

// At one bit error in a hundred bits no frame is delivered, and the aircraft must not move.
TEST(Faults, ALineThatFlipsEveryHundredthBitEndsWithThePilot) {
  RecordProperty("promise", "R12");
  FaultBench bench;
  ASSERT_TRUE(bench.take_off());
  bench.forget_worst();
  bench.world().autopilot_line().b_to_a().set_faults({.flip_per_bit = 0.01});
  EXPECT_TRUE(bench.until(FailsafeState::kSilent, milliseconds(1300)).has_value());
  bench.run(seconds(3));
  EXPECT_TRUE(bench.is_sound());
  EXPECT_LT(bench.farthest_m(), kMargin * kDeaf_m);
  EXPECT_FALSE(bench.world().autopilot().virtual_rc_on()) << "the autopilot did not end it although its data stopped";
}

/// A cable whose far end uses another baud rate.
class WrongBaudUart final : public hal::Uart {
 public:
  WrongBaudUart(hal::Uart& from, std::uint32_t sent, std::uint32_t received)
      : from_(from), sent_(sent), received_(received) {}
  core::Expected<std::size_t> read(std::span<std::byte> destination) override {
    std::array<std::byte, 128> raw;
    const auto count = from_.read(raw);
    if (!count) {
      return count.status();
    }
    const std::vector<std::byte> seen =
        hal::received_at({raw.begin(), raw.begin() + static_cast<std::ptrdiff_t>(*count)}, sent_, received_);
    const std::size_t size = std::min(seen.size(), destination.size());
    std::copy_n(seen.begin(), size, destination.begin());
    return size;
  }
  core::Expected<std::size_t> write(std::span<const std::byte> source) override { return source.size(); }

 private:
  hal::Uart& from_;
  std::uint32_t sent_;
  std::uint32_t received_;
};

TEST(Faults, AnotherBaudRateNeverBecomesReady) {
  RecordProperty("promise", "R12");
  for (const std::uint32_t baud : {115200U, 460800U, 921600U}) {
    sim::World world(sim::measured_plant(), {.seed = 5});
    WrongBaudUart wrong(world.autopilot_uart(), 230400, baud);
    link::LinkConfig config;
    config.app_id = 1;
    link::SerialLink link(wrong, config);
    link.request_control(world.now());
    for (int i = 0; i < 2000; ++i) {
      world.advance(core::kTickPeriod);
      (void)link.receive(world.now());
      ASSERT_FALSE(link.authority().in_control);
      ASSERT_NE(link.authority().stage, safety::AuthorityStage::kReady);
    }
    EXPECT_EQ(link.health().parser.frames, 0U);
    EXPECT_GT(link.health().bytes_received, 1000U);
  }
}

}  // namespace
}  // namespace m100::scenario
