// SPDX-License-Identifier: BSD-3-Clause
// The emulated autopilot's own estimate of its motion must be as wrong as in the measured logs: the same statistics,
// within the range of the two logs widened by the factor by which the logs differ.
#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <vector>

#include "host_tests/lab/logs/raw_log.h"
#include "host_tests/shared_files.h"
#include "host_tests/sim/autopilot/n1_telemetry.h"
#include "host_tests/sim/world/plant.h"

namespace m100::sim {
namespace {

using std::chrono::milliseconds;

/// Defects of a horizontal velocity, sampled every 10 ms in the air.
struct Defects {
  double zero_share = 0.0;
  double drift_rms_m_s = 0.0;     ///< of the samples that are not zero
  double largest_step_m_s = 0.0;  ///< from one sample to the next
  double longest_zero_s = 0.0;
};

Defects defects_of(const std::vector<double>& x, const std::vector<double>& y) {
  constexpr double kZero_m_s = 0.02;  // as in the validity column of the logs
  Defects out;
  double square = 0.0;
  double moving = 0.0;
  double zero_s = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const bool zero = std::abs(x[i]) < kZero_m_s && std::abs(y[i]) < kZero_m_s;
    zero_s = zero ? zero_s + 0.01 : 0.0;
    out.longest_zero_s = std::max(out.longest_zero_s, zero_s);
    out.zero_share += zero ? 1.0 / static_cast<double>(x.size()) : 0.0;
    square += zero ? 0.0 : x[i] * x[i] + y[i] * y[i];
    moving += zero ? 0.0 : 1.0;
    out.largest_step_m_s = std::max(out.largest_step_m_s, i > 0 ? std::hypot(x[i] - x[i - 1], y[i] - y[i - 1]) : 0.0);
  }
  out.drift_rms_m_s = std::sqrt(square / std::max(1.0, moving));
  return out;
}

std::vector<double> airborne(const std::string& file, const std::string& column, double from_s, double to_s) {
  const auto log = lab::logs::open_log(file);
  const std::vector<double> time_s = log->column("t_s", "test").values;
  const std::vector<double> all = log->column(column, "test").values;
  std::vector<double> out;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (time_s[i] >= from_s && time_s[i] <= to_s) {
      out.push_back(all[i]);
    }
  }
  return out;
}

N1SensorNoise as_measured() {
  const Sensors sensors;
  return {.force_offset_m_s2 = sensors.imu_offset_m_s2,
          .force_vibration_m_s2 = sensors.imu_vibration_m_s2,
          .velocity_zero_share = sensors.velocity_zero_share,
          .height_drift_m = sensors.height_drift_m};
}

/// An aircraft that is moved by hand at 1 m/s, as in the logs.
VehicleState moved_by_hand(double t_s) {
  VehicleState truth;
  truth.motors_on = true;
  truth.in_air = true;
  truth.position_w_m.z() = 1.5;
  truth.velocity_w_m_s.x() = std::sin(1.7 * t_s);
  truth.velocity_w_m_s.y() = 0.5 * std::sin(1.1 * t_s + 1.0);
  return truth;
}

template <typename Visit>
void estimate_minute(std::uint64_t seed, const Visit& visit) {
  N1Estimator estimator(as_measured(), seed);
  for (int i = 0; i < 6000; ++i) {
    visit(estimator.update(moved_by_hand(0.01 * i), milliseconds(10)));
  }
}

TEST(N1Estimator, HorizontalVelocityIsZeroDriftsAndJumpsBackAsInTheMeasuredLogs) {
  M100_SHARED_FILE_OR_SKIP(pitch_roll, "data/m100/pitch_roll.csv");
  M100_SHARED_FILE_OR_SKIP(height, "data/m100/height.csv");
  const Defects first =
      defects_of(airborne(pitch_roll, "odom_vx_m_s", 8.0, 55.0), airborne(pitch_roll, "odom_vy_m_s", 8.0, 55.0));
  const Defects second =
      defects_of(airborne(height, "odom_vx_m_s", 4.0, 64.0), airborne(height, "odom_vy_m_s", 4.0, 64.0));
  Defects mean;
  constexpr int kMinutes = 50;
  for (int minute = 1; minute <= kMinutes; ++minute) {
    std::vector<double> x;
    std::vector<double> y;
    estimate_minute(static_cast<std::uint64_t>(minute), [&](const VehicleState& estimated) {
      x.push_back(estimated.velocity_w_m_s.x());
      y.push_back(estimated.velocity_w_m_s.y());
    });
    const Defects one = defects_of(x, y);
    mean.zero_share += one.zero_share / kMinutes;
    mean.drift_rms_m_s += one.drift_rms_m_s / kMinutes;
    mean.largest_step_m_s += one.largest_step_m_s / kMinutes;
    mean.longest_zero_s += one.longest_zero_s / kMinutes;
  }
  const auto expect_between = [](double simulated, double one, double other, const char* what) {
    EXPECT_GE(simulated, std::min(one, other) / 1.5) << what;
    EXPECT_LE(simulated, std::max(one, other) * 1.5) << what;
  };
  EXPECT_GT(mean.zero_share, 1.0 / 3.0);
  expect_between(mean.zero_share, first.zero_share, second.zero_share, "share of the time at zero");
  expect_between(mean.drift_rms_m_s, first.drift_rms_m_s, second.drift_rms_m_s, "speed while it drifts");
  expect_between(mean.largest_step_m_s, first.largest_step_m_s, second.largest_step_m_s, "jump");
  expect_between(mean.longest_zero_s, first.longest_zero_s, second.longest_zero_s, "longest stretch at zero");
}

TEST(N1Estimator, TheForceHasAnOffsetOfTenthsThatDiffersFromFlightToFlight) {
  M100_SHARED_FILE_OR_SKIP(pitch_roll, "data/m100/pitch_roll.csv");
  M100_SHARED_FILE_OR_SKIP(height, "data/m100/height.csv");
  const auto mean_of = [](const std::vector<double>& values) {
    double sum = 0.0;
    for (const double value : values) {
      sum += value / static_cast<double>(values.size());
    }
    return sum;
  };
  // A flight that begins and ends at rest has a mean acceleration of zero; the measured mean is the offset.
  double measured_square = 0.0;
  for (const char* const column : {"imu_acc_north_m_s2", "imu_acc_east_m_s2"}) {
    measured_square += std::pow(mean_of(airborne(pitch_roll, column, 7.0, 62.0)), 2.0) / 4.0;
    measured_square += std::pow(mean_of(airborne(height, column, 3.0, 65.0)), 2.0) / 4.0;
  }
  double square = 0.0;
  constexpr int kFlights = 20;
  for (int flight = 1; flight <= kFlights; ++flight) {
    core::Vector<double, 3> sum = core::Vector<double, 3>::Zero();
    estimate_minute(static_cast<std::uint64_t>(flight), [&](const VehicleState& estimated) {
      sum += (estimated.specific_force_b_m_s2 - VehicleState{}.specific_force_b_m_s2) / 6000.0;
    });
    square += (sum.x() * sum.x() + sum.y() * sum.y()) / (2.0 * kFlights);
  }
  // Four measurements give their root mean square to a factor of two (chi-squared, 95 %).
  EXPECT_GT(std::sqrt(square), std::sqrt(measured_square) / 2.0);
  EXPECT_LT(std::sqrt(square), std::sqrt(measured_square) * 2.0);
}

TEST(N1Estimator, HeightDriftsByTenthsOfAMetreInAMinuteAndIsSetAnewAfterLanding) {
  double mean_range_m = 0.0;
  constexpr int kFlights = 20;
  for (int flight = 1; flight <= kFlights; ++flight) {
    double low = 1e9;
    double high = -1e9;
    estimate_minute(static_cast<std::uint64_t>(flight), [&](const VehicleState& estimated) {
      low = std::min(low, estimated.position_w_m.z() - 1.5);
      high = std::max(high, estimated.position_w_m.z() - 1.5);
    });
    mean_range_m += (high - low) / kFlights;
  }
  // Measured against the integral of the climb speed: 1.04 m in pitch_roll.csv and 0.93 m in height.csv.
  EXPECT_NEAR(mean_range_m, 1.0, 0.4);

  N1Estimator estimator({.height_drift_m = 0.3}, 1);
  const double before_m = estimator.update(moved_by_hand(0.0), milliseconds(10)).position_w_m.z();
  VehicleState landed = moved_by_hand(0.0);
  landed.in_air = false;
  EXPECT_GT(std::abs(estimator.update(landed, milliseconds(10)).position_w_m.z() - before_m), 0.02);  // one sample
}

TEST(N1Estimator, AreTheTruthWhereNothingIsWrong) {
  N1Estimator estimator({}, 1);
  const VehicleState truth = moved_by_hand(3.0);
  const VehicleState estimated = estimator.update(truth, milliseconds(10));
  EXPECT_EQ(estimated.velocity_w_m_s, truth.velocity_w_m_s);
  EXPECT_EQ(estimated.position_w_m, truth.position_w_m);
  EXPECT_EQ(estimated.specific_force_b_m_s2, truth.specific_force_b_m_s2);
}

}  // namespace
}  // namespace m100::sim
