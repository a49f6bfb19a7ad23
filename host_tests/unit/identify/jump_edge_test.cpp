// SPDX-License-Identifier: BSD-3-Clause
// A dead zone that jumps, swept slowly: its edge lies between two stick values, and the interval must say so.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "firmware/model/stick_axis.h"
#include "firmware/sysid/axis_dynamics.h"
#include "host_tests/lab/identify/axis_pipeline.h"
#include "host_tests/lab/logs/flight_log.h"
#include "host_tests/unit/identify/one_log.h"

namespace m100::lab::identify {
namespace {

constexpr double kWidth_counts = 31.0;
constexpr double kGap_counts = 3.0;  ///< between two values of the stick on its ramp

/// 16 s: two steps of 0.6 s, then a ramp to either side that holds each value for 40 ms.
double swept(double t_s) {
  const double into_s = std::fmod(t_s, 16.0);
  const double side = std::fmod(t_s, 32.0) < 16.0 ? 1.0 : -1.0;
  if (into_s < 1.2) {
    return side * (into_s < 0.6 ? 150.0 : -150.0);
  }
  if (into_s < 4.0 || into_s > 12.0) {
    return 0.0;
  }
  const double turn = (std::floor((into_s - 4.0) / 0.04) * 0.04) / 8.0;
  const double shape = turn < 0.25 ? 4.0 * turn : turn < 0.75 ? 2.0 - 4.0 * turn : 4.0 * turn - 4.0;
  return side * kGap_counts * std::round(90.0 * shape / kGap_counts);
}

logs::FlightLog flown() {
  model::StickAxis axis{.scale_per_count = 9.0e-4, .natural_frequency_rad_s = 8.5, .damping_ratio = 0.7};
  axis.dead_zone_counts = kWidth_counts;
  axis.dead_zone_shape = model::DeadZoneShape::kJump;
  logs::FlightLog log;
  log.size = 9600;
  std::mt19937_64 random(5);
  std::normal_distribution<double> noise_rad(0.0, 0.002);
  model::StickLaw<double> law(axis, log.period_s);
  sysid::AxisDynamics<double> dynamics(axis, log.period_s);
  dynamics.start(0.0, 0.0);
  for (std::size_t k = 0; k < log.size; ++k) {
    const double stick = swept(log.time_s(k));
    log.of(logs::Signal::kStickRoll).push_back(stick);
    log.of(logs::Signal::kAttitudeRoll).push_back(dynamics.value() + noise_rad(random));
    dynamics.step(law.command(stick, 0.0, log.time_s(k)));
  }
  return log;
}

// Every refit ended at the same place, so that the interval had no width and missed the edge.
TEST(JumpEdge, HasAnIntervalAsWideAsTheGapOfTheStick) {
  const logs::FlightLog log = flown();
  Request request = about(log, "roll", {"second_order", "dead_zone"}, {1.0, 64.0}, {64.0, 95.0});
  request.refits = 20;
  const IdentifyResult result = identify_axis(request);
  EXPECT_EQ(result.final_model.dead_zone_shape, "jump");
  const auto width = std::find_if(result.final_intervals.begin(), result.final_intervals.end(),
                                  [](const NamedInterval& one) { return one.name == "width_counts"; });
  ASSERT_NE(width, result.final_intervals.end());
  EXPECT_LE(width->interval.low, kWidth_counts);
  EXPECT_GE(width->interval.high, kWidth_counts);
  EXPECT_GE(width->interval.high - width->interval.low, 0.9 * kGap_counts);
  EXPECT_LE(width->interval.high - width->interval.low, 4.0 * kGap_counts);
}

}  // namespace
}  // namespace m100::lab::identify
