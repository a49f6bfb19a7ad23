// SPDX-License-Identifier: BSD-3-Clause
// A thousand healthy flights, each with a lever arm, a vibration, wind or an announced jump: nothing may be refused.
// Nightly.
#include <cstdio>
#include <string>

#include "host_tests/scenario/faults/flight_sequencer_fixture.h"
#include "host_tests/sim/world/random.h"

namespace m100::scenario {
namespace {

using Vector = core::Vector<double, 3>;
using HealthyFlights = FlightSequencerTest;
INSTANTIATE_TEST_SUITE_P(Channels, HealthyFlights,
                         ::testing::Values(link::Channel::kVirtualRc, link::Channel::kMovement));

/// In a ball of this radius.
Vector drawn_inside(double radius, sim::Random& random) {
  for (;;) {
    Vector point;
    for (double& coordinate : point) {
      coordinate = 2.0 * random.uniform() - 1.0;
    }
    if (point.squaredNorm() <= 1.0) {
      return point * radius;
    }
  }
}

sim::Plant drawn_plant(sim::Random& random) {
  sim::Plant plant = sim::measured_plant();
  plant.sensors.imu_vibration_m_s2 = 3.0 * random.uniform();
  if (random.next() % 2 == 0) {
    plant.air.linear_drag_per_s = 0.3;
    plant.air.wind_m_s = {4.0, -3.0, 0.0};
    plant.air.gust_m_s = 1.5;
    plant.air.turbulence_m_s = 0.75;
  }
  return plant;
}

TEST_P(HealthyFlights, AreFlownToTheirEndWithoutARefusal) {
  RecordProperty("promise", "R17");
  constexpr int kFlights = 500, kSeconds = 20;
  sim::Random random(8101, "healthy");
  int ended = 0, jumps = 0, told = 0;
  for (int i = 0; i < kFlights; ++i) {
    heard_ = {};
    ended_ = false;
    const Vector lever_b_m = drawn_inside(0.3, random);
    const link::LeverArm stated_b_m{static_cast<float>(lever_b_m.x()), static_cast<float>(lever_b_m.y()),
                                    static_cast<float>(lever_b_m.z())};
    const sim::Plant plant = drawn_plant(random);
    begin({.take_control = true, .hold_s = 1000.0}, {}, plant, stated_b_m,
          {.seed = random.next() % 10000, .autopilot = {.pilot_holds_position = true}});
    bench_->pose_line().set_lever_arm(lever_b_m, [&] { return bench_->world().vehicle().attitude(); });
    const Vector start = bench_->place();
    for (int leg = 0; leg < 4; ++leg) {
      const Vector by_m = drawn_inside(2.0, random);
      const double yaw_rad = 6.0 * random.uniform() - 3.0;
      ASSERT_EQ(bench_->course().append_step({start + Vector(by_m.x(), by_m.y(), 0.3 * by_m.z()), yaw_rad}, seconds(5)),
                core::Status::kOk);
    }
    const int jumps_at = static_cast<int>(random.next() % (2 * kSeconds));  // in every other flight
    bool flies = fly_for(seconds(1));
    for (int second = 0; second < kSeconds && flies; ++second) {
      if (second == jumps_at) {
        const Vector by_m = drawn_inside(0.5, random);
        bench_->pose_line().jump(by_m, 0.3 * (random.uniform() - 0.5), true);
        ++jumps;
      }
      flies = fly_for(seconds(1));
    }
    told += static_cast<int>(heard_.has("refused") || heard_.has("crash"));
    if (!flies) {
      ++ended;
      std::printf("flight %d: %s\n", i, heard_.all().c_str());
    }
  }
  EXPECT_EQ(ended, 0);
  EXPECT_EQ(told, 0);
  std::printf("%d of %d flights ended, %d with a refusal, %d announced jumps\n", ended, kFlights, told, jumps);
}

}  // namespace
}  // namespace m100::scenario
