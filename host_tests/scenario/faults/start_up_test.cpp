// SPDX-License-Identifier: BSD-3-Clause
// Tests how a flight by the control law begins, and which orders begin one.
#include <gtest/gtest.h>

#include "host_tests/scenario/faults/fault_bench.h"

namespace m100::scenario {
namespace {

// Catches a course that starts only after its first command was sent: until then its time counts from the start of the
// program, and the command is computed for the course's end, 2 m away.
TEST(Beginning, TheFirstCommandIsComputedForTheBeginningOfTheCourse) {
  FaultBench bench;
  ref::Waypoint<double> there;
  there.position_w_m = bench.place() + core::Vector<double, 3>{2.0, 0.0, 0.5};
  ASSERT_EQ(bench.course().append_quintic(there, seconds(1)), core::Status::kOk);
  bench.run(seconds(2));
  ASSERT_EQ(bench.controller().link().authority().stage, safety::AuthorityStage::kReady);
  for (int flight = 0; flight < 2; ++flight) {
    bench.controller().engage();
    ASSERT_TRUE(bench.until(FailsafeState::kNominal, seconds(10)).has_value()) << flight;
    const ref::Window<double>& reference = bench.controller().reference();
    // Tolerance: after the transport delay of 40 ms, a quintic of 1 s has moved by 1.3 mm.
    EXPECT_NEAR(reference.x[0].position_m, bench.place().x(), 0.01) << flight;
    EXPECT_NEAR(reference.height.position_m, bench.place().z(), 0.01) << flight;
    EXPECT_EQ(bench.controller().started(), bench.world().now()) << flight;
    bench.run(milliseconds(200));
    bench.controller().release();
    ASSERT_TRUE(bench.until(FailsafeState::kSilent, seconds(3)).has_value());
    bench.run(seconds(3));
  }
}

// Catches an order that was given while the law flew, had no effect then, and later ends a descent of the failsafe
// without a new order.
TEST(Beginning, AnOrderGivenWhileTheLawFliesIsNotKeptForTheNextDescent) {
  FaultBench bench;
  ASSERT_TRUE(bench.take_off());
  bench.controller().engage();
  bench.run(seconds(1));
  bench.world().pose_source().set_faults({.silent = true});
  ASSERT_TRUE(bench.until(FailsafeState::kLevel, seconds(2)).has_value());
  bench.world().pose_source().set_faults({});
  EXPECT_TRUE(bench.until(FailsafeState::kRelease, milliseconds(1100)).has_value())
      << static_cast<int>(bench.failsafe_state());
  EXPECT_EQ(bench.controller().supervisor().descent().to, FailsafeState::kCoast);
}

/// A line on which nothing passes for a while, without a sign that it is unplugged.
class DeadLine final : public hal::Uart {
 public:
  explicit DeadLine(hal::Uart& line) : line_(line) {}
  void set_dead(bool dead) { dead_ = dead; }
  core::Expected<std::size_t> read(std::span<std::byte> destination) override {
    const core::Expected<std::size_t> count = line_.read(destination);
    return dead_ ? core::Expected<std::size_t>(0) : count;
  }
  core::Expected<std::size_t> write(std::span<const std::byte> source) override {
    return dead_ ? core::Expected<std::size_t>(source.size()) : line_.write(source);
  }

 private:
  hal::Uart& line_;
  bool dead_ = true;
};

// Catches an order that is kept for an autopilot that is switched on much later, and then takes control from the pilot.
TEST(Beginning, AnOrderGivenWhileTheAutopilotIsSilentGrowsOld) {
  RecordProperty("promise", "R4");
  const mpc::GainTables<float> tables{mpc::generated::kX<float>, mpc::generated::kY<float>};
  for (const int dead_s : {5, 25}) {
    sim::World world(sim::measured_plant(), {.seed = 5});
    DeadLine line(world.autopilot_uart());
    const auto course = std::make_unique<ref::Trajectory<float>>();
    course->hold({.position_w_m = world.vehicle().state().position_w_m.cast<float>()});
    app::FlightConfig config = app::kDefaultFlight;
    config.link.app_id = 1;
    app::FlightController<float> controller(mpc::generated::kVehicle, tables, config, line, world.pose_uart(), *course,
                                            nullptr);
    controller.engage();
    for (int k = 0; k < 100 * (dead_s + 15); ++k) {
      line.set_dead(k < 100 * dead_s);
      world.advance(core::kTickPeriod);
      static_cast<void>(controller.tick(world.now()));
    }
    EXPECT_EQ(world.autopilot().record().obtain_requests > 0, dead_s < 20) << dead_s;
    EXPECT_EQ(controller.grant().failsafe_state == FailsafeState::kNominal, dead_s < 20) << dead_s;
  }
}

// The counterpart: the order counts while the law does not fly.
TEST(Beginning, AnOrderGivenInLevelGoesUpWhenPosesAreBack) {
  FaultBench bench;
  ASSERT_TRUE(bench.take_off());
  bench.world().pose_source().set_faults({.silent = true});
  ASSERT_TRUE(bench.until(FailsafeState::kLevel, seconds(2)).has_value());
  bench.world().pose_source().set_faults({});
  bench.controller().engage();
  EXPECT_TRUE(bench.until(FailsafeState::kNominal, milliseconds(900)).has_value())
      << static_cast<int>(bench.failsafe_state());
}

// Catches an observer that gives up the attitude before telemetry counts as old, which ended the flight.
TEST(TelemetryGap, OfATenthToFourTenthsOfASecondIsCoastedThrough) {
  RecordProperty("promise", "R12");
  for (const double gap_s : {0.12, 0.2, 0.4}) {
    FaultBench bench;
    ASSERT_TRUE(bench.take_off());
    bench.world().autopilot().happen(sim::N1EventKind::kSilence, gap_s);
    EXPECT_TRUE(bench.until(FailsafeState::kCoast, milliseconds(140)).has_value())
        << gap_s << " " << static_cast<int>(bench.failsafe_state());
    EXPECT_EQ(bench.controller().supervisor().last_step().reason, safety::FailsafeReason::kTelemetryOld) << gap_s;
    EXPECT_TRUE(bench.until(FailsafeState::kNominal, seconds(1)).has_value())
        << gap_s << " " << static_cast<int>(bench.failsafe_state());
    EXPECT_EQ(bench.controller().supervisor().stats().levels, 0U) << gap_s;
    EXPECT_LT(bench.farthest_m(), 0.3) << gap_s;
    EXPECT_TRUE(bench.is_sound());
  }
}

}  // namespace
}  // namespace m100::scenario
