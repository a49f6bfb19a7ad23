// SPDX-License-Identifier: BSD-3-Clause
// A take-off by the autopilot's own task, which ignores the commands and does not hold its place, in a wind.
#include "host_tests/scenario/faults/flight_sequencer_fixture.h"

namespace m100::scenario {
namespace {

struct WindyTakeOff {
  double wind_m_s;
  double direction_rad;
  double side_m;  ///< of the fence, from the take-off; the wind carries the aircraft almost to it
};

class TakeOffTest : public FlightSequencerTest {
 protected:
  void begin_on_ground(const WindyTakeOff& in) {
    sim::Plant plant = sim::measured_plant();
    plant.air.wind_m_s = {in.wind_m_s * std::cos(in.direction_rad), in.wind_m_s * std::sin(in.direction_rad), 0.0};
    plant.air.linear_drag_per_s = kDrag_per_s;
    const core::Fence::Side side{-in.side_m, in.side_m};
    begin({.take_control = true, .hold_s = 5.0, .once = true, .take_off = true},
          {.side = {side, side, core::Fence::Side{0.3, 4.0}}, .wind_m_s = 5.0}, plant, {},
          {.seed = 5, .position_w_m = core::Vector<double, 3>::Zero()});
    bench_->world().vehicle().set_motors(false);
  }
  const sim::VehicleState& truth() { return bench_->world().vehicle().state(); }
  double speed_m_s() { return truth().velocity_w_m_s.head<2>().norm(); }

  static constexpr double kDrag_per_s = 0.3;
};

INSTANTIATE_TEST_SUITE_P(Faults, TakeOffTest, ::testing::Values(link::Channel::kVirtualRc, link::Channel::kMovement),
                         [](const auto& one) {
                           return one.param == link::Channel::kVirtualRc ? "VirtualRc" : "Movement";
                         });

// Catches an observer that takes the ignored commands for flown: it believed in a trim of 0.11 to 0.16 rad. And a stop
// that eases the brakes too early: in 4 and 5 m/s of wind it ended 0.24 to 0.43 m behind these fences. The direction
// matters because the autopilot's own level is 0.4 degrees off.
TEST_P(TakeOffTest, InAWindOfTheClassEndsAtTheFenceAndSlowly) {
  for (const WindyTakeOff& in :
       {WindyTakeOff{5.0, 3.14, 2.9}, WindyTakeOff{5.0, 1.57, 3.15}, WindyTakeOff{5.0, -0.79, 2.1},
        WindyTakeOff{4.0, 0.0, 2.35}, WindyTakeOff{3.0, 2.3, 1.25}}) {
    SCOPED_TRACE(in.wind_m_s);
    SCOPED_TRACE(in.direction_rad);
    ended_ = false;
    begin_on_ground(in);
    ASSERT_TRUE(until([&] { return truth().position_w_m.z() > 1.1; }, seconds(20))) << heard_.all();
    const est::Estimate<double>& seen = bench_->controller().estimate();
    EXPECT_NEAR(std::hypot(seen.x.disturbance_m_s2, seen.y.disturbance_m_s2), kDrag_per_s * (in.wind_m_s - speed_m_s()),
                0.2);
    EXPECT_LT(std::hypot(seen.x.input_offset_rad, seen.y.input_offset_rad), 0.03);
    double far_m = 0.0;
    const auto ends = [&] {
      far_m = std::max(far_m, truth().position_w_m.head<2>().cwiseAbs().maxCoeff());
      return is_pilots();
    };
    EXPECT_TRUE(until(ends, seconds(20))) << heard_.all();
    EXPECT_LT(far_m, in.side_m + 0.3) << heard_.all();
    EXPECT_LT(speed_m_s(), 0.5) << heard_.all();
  }
}

}  // namespace
}  // namespace m100::scenario
