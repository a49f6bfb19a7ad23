// SPDX-License-Identifier: BSD-3-Clause
// How a flight by the law begins, and which orders begin one.
#include <gtest/gtest.h>

#include "host_tests/scenario/faults/fault_bench.h"

namespace m100::scenario {
namespace {

// Catches a course that is started after its first command has left: until then its time counts from the start of the
// program, so the command is computed for the course's end, 2 m away.
TEST(Beginning, TheFirstCommandIsComputedForTheBeginningOfTheCourse) {
  FaultBench bench;
  ref::Waypoint<double> there;
  there.position_w_m = bench.place() + core::Vector<double, 3>{2.0, 0.0, 0.5};
  ASSERT_EQ(bench.course().append_quintic(there, seconds(1)), core::Status::kOk);
  bench.run(seconds(2));
  ASSERT_EQ(bench.controller().link().authority().stage, safety::Stage::kReady);
  for (int flight = 0; flight < 2; ++flight) {
    bench.controller().engage();
    ASSERT_TRUE(bench.until(Rung::kNominal, seconds(10)).has_value()) << flight;
    const ref::Window<double>& reference = bench.controller().reference();
    // 40 ms of transport delay into a quintic of 1 s are 1.3 mm.
    EXPECT_NEAR(reference.x[0].position_m, bench.place().x(), 0.01) << flight;
    EXPECT_NEAR(reference.height.position_m, bench.place().z(), 0.01) << flight;
    EXPECT_EQ(bench.controller().started(), bench.world().now()) << flight;
    bench.run(milliseconds(200));
    bench.controller().release();
    ASSERT_TRUE(bench.until(Rung::kSilent, seconds(3)).has_value());
    bench.run(seconds(3));
  }
}

// Catches an order that was given while the law flew, had nothing to do, and brings the next descent up again by
// itself.
TEST(Beginning, AnOrderGivenWhileTheLawFliesIsNotKeptForTheNextDescent) {
  FaultBench bench;
  ASSERT_TRUE(bench.take_off());
  bench.controller().engage();
  bench.run(seconds(1));
  bench.world().pose_source().set_faults({.silent = true});
  ASSERT_TRUE(bench.until(Rung::kLevel, seconds(2)).has_value());
  bench.world().pose_source().set_faults({});
  EXPECT_TRUE(bench.until(Rung::kRelease, milliseconds(1100)).has_value()) << static_cast<int>(bench.rung());
  EXPECT_EQ(bench.controller().supervisor().descent().to, Rung::kCoast);
}

// The other side of it: the order counts where the law does not fly.
TEST(Beginning, AnOrderGivenInLevelGoesUpWhenPosesAreBack) {
  FaultBench bench;
  ASSERT_TRUE(bench.take_off());
  bench.world().pose_source().set_faults({.silent = true});
  ASSERT_TRUE(bench.until(Rung::kLevel, seconds(2)).has_value());
  bench.world().pose_source().set_faults({});
  bench.controller().engage();
  EXPECT_TRUE(bench.until(Rung::kNominal, milliseconds(900)).has_value()) << static_cast<int>(bench.rung());
}

// Catches an observer that loses the attitude before telemetry is called old: the flight ended where it had to coast.
TEST(TelemetryGap, OfATenthToFourTenthsOfASecondIsCoastedThrough) {
  RecordProperty("promise", "R12");
  for (const double gap_s : {0.12, 0.2, 0.4}) {
    FaultBench bench;
    ASSERT_TRUE(bench.take_off());
    bench.world().autopilot().happen(sim::N1Happening::kSilence, gap_s);
    EXPECT_TRUE(bench.until(Rung::kCoast, milliseconds(140)).has_value())
        << gap_s << " " << static_cast<int>(bench.rung());
    EXPECT_EQ(bench.controller().supervisor().last_step().cause, safety::Cause::kTelemetryOld) << gap_s;
    EXPECT_TRUE(bench.until(Rung::kNominal, seconds(1)).has_value()) << gap_s << " " << static_cast<int>(bench.rung());
    EXPECT_EQ(bench.controller().supervisor().stats().levels, 0U) << gap_s;
    EXPECT_LT(bench.farthest_m(), 0.3) << gap_s;
    EXPECT_TRUE(bench.is_sound());
  }
}

}  // namespace
}  // namespace m100::scenario
