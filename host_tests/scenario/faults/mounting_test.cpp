// SPDX-License-Identifier: BSD-3-Clause
// What the mounting makes of right sensors: a pose whose origin lies beside the centre of gravity, and vibration.
#include <array>
#include <cmath>
#include <cstdio>
#include <vector>

#include "host_tests/scenario/faults/flight_sequencer_fixture.h"

namespace m100::scenario {
namespace {

using MountingTest = FlightSequencerTest;
INSTANTIATE_TEST_SUITE_P(Mounting, MountingTest,
                         ::testing::Values(link::Channel::kVirtualRc, link::Channel::kMovement));

// A turn in place, then steps and turns together: the aircraft flies as if the origin of its poses were its centre of
// gravity. Catches an offset of the wrong sign or axes, one without the tilt, and a start or a fence that ignores it.
TEST_P(MountingTest, AStatedLeverArmChangesNoFlight) {
  using Vector = core::Vector<double, 3>;
  std::vector<Vector> without;
  for (const link::LeverArm& lever_b_m :
       {link::LeverArm{}, {0.3F, 0.F, 0.F}, {0.F, -0.3F, 0.F}, {0.F, 0.F, 0.3F}, {-0.2F, 0.15F, -0.17F}}) {
    begin({.take_control = true, .hold_s = 1000.0}, {}, sim::measured_plant(), lever_b_m);
    bench_->pose_line().set_lever_arm(Vector(lever_b_m[0], lever_b_m[1], lever_b_m[2]),
                                      [&] { return bench_->world().vehicle().attitude(); });
    const Vector start = bench_->place();
    for (const auto& [by_m, yaw_rad] : {std::pair{Vector(0.0, 0.0, 0.0), 0.0},
                                        {Vector(0.0, 0.0, 0.0), 1.57},
                                        {Vector(2.0, 0.0, 0.5), 3.0},
                                        {Vector(2.0, 2.0, 0.0), -1.5},
                                        {Vector(0.0, 0.0, 0.0), 0.0}}) {
      ASSERT_EQ(bench_->course().append_step({start + by_m, yaw_rad}, seconds(5)), core::Status::kOk);
    }
    std::vector<Vector> flown;
    ASSERT_TRUE(fly_for(seconds(1))) << heard_.all();
    for (int i = 0; i < 25; ++i) {
      ASSERT_TRUE(fly_for(seconds(1))) << lever_b_m[0] << " " << lever_b_m[1] << " " << lever_b_m[2] << heard_.all();
      flown.push_back(bench_->world().vehicle().state().position_w_m);
      without.resize(std::max(without.size(), flown.size()), flown.back());
      EXPECT_LT((flown.back() - without[flown.size() - 1]).norm(), 0.02) << "as without a lever arm, at " << i << " s";
    }
  }
}

// Catches a refusal that blames the pose, and does not say that its origin is where nobody stated it.
TEST_P(MountingTest, ALeverArmThatNobodyStatedIsNamedByItsSize) {
  for (const double heading_b_rad : {0.0, 1.6, -2.2}) {
    heard_ = {};
    begin({.take_control = true, .hold_s = 1000.0});
    const core::Vector<double, 2> lever_b_m = core::rotate_by_yaw<double>({0.2, 0.0}, heading_b_rad);
    bench_->pose_line().set_lever_arm({lever_b_m.x(), lever_b_m.y(), 0.0},
                                      [&] { return bench_->world().vehicle().attitude(); });
    ASSERT_EQ(bench_->course().append_step({bench_->place(), 0.0}, seconds(5)), core::Status::kOk);
    ASSERT_EQ(bench_->course().append_step({bench_->place(), 1.57}, seconds(5)), core::Status::kOk);
    ASSERT_TRUE(fly_for(seconds(3))) << heard_.all();
    ASSERT_TRUE(until([&] { return is_pilots(); }, seconds(10))) << heard_.all();
    const std::string all = heard_.all();
    const std::size_t at = all.rfind("set offset_m = [");
    ASSERT_NE(at, std::string::npos) << all;
    std::array<double, 2> found_m{};
    ASSERT_EQ(std::sscanf(all.c_str() + at, "set offset_m = [%lf, %lf", &found_m[0], &found_m[1]), 2) << all;
    EXPECT_LT(std::hypot(found_m[0] - lever_b_m.x(), found_m[1] - lever_b_m.y()), 0.3 * 0.2) << all;
  }
}

// A chipped propeller in a hover. Catches a vibration that is blamed on the pose or taken for a crash, one that is not
// told, and one that hides every false pose in silence.
TEST_P(MountingTest, AVibrationEndsNoHoverUpTo8AndIsNamedBeyond) {
  for (const double vibration_m_s2 : {0.1, 3.0, 8.0, 12.0}) {
    sim::Plant plant = sim::measured_plant();
    plant.sensors.imu_vibration_m_s2 = vibration_m_s2;
    heard_ = {};
    begin({.take_control = true, .hold_s = 1000.0}, {}, plant);
    (void)fly_for(seconds(3));  // the start from the autopilot's hover
    bench_->forget_worst();
    EXPECT_EQ(fly_for(seconds(25)), vibration_m_s2 < 9.0) << heard_.all();
    EXPECT_EQ(heard_.has("vibration of the specific force above 15 Hz"), vibration_m_s2 > 1.0) << heard_.all();
    EXPECT_EQ(heard_.has("nominal to level, vibration"), vibration_m_s2 > 9.0) << heard_.all();
    EXPECT_FALSE(heard_.has("crash") || heard_.has("pose refused")) << heard_.all();
    EXPECT_LT(bench_->farthest_m(), 0.2) << "as without vibration";
  }
}

}  // namespace
}  // namespace m100::scenario
