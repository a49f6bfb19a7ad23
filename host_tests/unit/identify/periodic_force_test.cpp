// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/residual_tests/periodic_force.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace m100::lab::identify {
namespace {

constexpr double kLine_hz = 0.31;
constexpr double kPeriod_s = 0.04;

TimeSeries noise_and_line(double sine, double cosine, double noise, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> gauss(0.0, noise);
  TimeSeries out;
  for (int k = 0; k < 700; ++k) {
    const double t = 3.0 + kPeriod_s * k;
    const double phase = 2.0 * std::numbers::pi * kLine_hz * t;
    out.time_s.push_back(t);
    out.values.push_back(sine * std::sin(phase) + cosine * std::cos(phase) + gauss(random));
  }
  return out;
}

VehicleMotion gust(std::vector<double> velocity_x) {
  VehicleMotion out{.frequency_hz = kLine_hz,
                    .force = {{{0.0, 0.5}, {0.0, 0.0}}},
                    .residual = {noise_and_line(0.5, 0.0, 0.05, 1), noise_and_line(0.0, 0.0, 0.05, 2)},
                    .channels = {},
                    .speed_m_s = {}};
  out.channels.push_back({.name = "velocity_x", .moved_by_axis = 0, .values = std::move(velocity_x)});
  return out;
}

TEST(StrongestLine, IsFoundInNoiseWithItsShare) {
  const SpectralPeak line = strongest_peak({noise_and_line(0.3, 0.4, 0.2, 1), noise_and_line(0.0, 0.0, 0.2, 2)});
  EXPECT_NEAR(line.frequency_hz, kLine_hz, 0.01);  // a quarter of the resolution of 28 s
  EXPECT_NEAR(line.share, 0.125 / (0.125 + 0.08), 0.08);
}

TEST(VehicleMotion, AllowsAForceThatMovesTheVehicle) {
  // v is the velocity of a mass under 0.5 sin(wt), plus slow wandering; without the subtraction the line holds most of
  // it.
  TimeSeries v = noise_and_line(0.0, -0.5 / (2.0 * std::numbers::pi * kLine_hz), 0.02, 3);
  EXPECT_GT(share_at(v, kLine_hz), 0.5);
  EXPECT_EQ(check_vehicle_motion(gust(v.values)), "");
}

// A vehicle that flies a periodic path shows that line in every signal.
TEST(VehicleMotion, RefusesALineThatTheVehicleFlies) {
  const TimeSeries v = noise_and_line(1.5, 0.0, 0.1, 3);
  EXPECT_NE(check_vehicle_motion(gust(v.values)).find("velocity_x has"), std::string::npos);
}

TEST(VehicleMotion, AllowsALineThatHoveringShowsToo) {
  VehicleMotion motion = gust(noise_and_line(1.5, 0.0, 0.1, 3).values);
  for (std::size_t k = 0; k < 700; ++k) {
    motion.speed_m_s.push_back(k < 400 ? 1.5 : 0.1);
  }
  EXPECT_EQ(check_vehicle_motion(motion), "");
}

TEST(VehicleMotion, RefusesALineThatEndsWhereTheVehicleHovers) {
  VehicleMotion motion = gust(noise_and_line(1.5, 0.0, 0.1, 3).values);
  const TimeSeries quiet = noise_and_line(0.0, 0.0, 0.05, 9);
  for (std::size_t k = 0; k < 700; ++k) {
    motion.speed_m_s.push_back(k < 400 ? 1.5 : 0.1);
    if (k >= 400) {
      motion.residual[0].values[k] = quiet.values[k];
    }
  }
  EXPECT_NE(check_vehicle_motion(motion), "");
}

}  // namespace
}  // namespace m100::lab::identify
