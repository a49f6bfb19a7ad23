// SPDX-License-Identifier: BSD-3-Clause
// The information about the pose in a calm hover: the bound behind the sensor faults that THREATS.md lists as unseen.
#include <gtest/gtest.h>

#include <array>
#include <numbers>

#include "host_tests/scenario/sensor_faults/sensor_fault_bench.h"

namespace m100::scenario {
namespace {

constexpr double kTick_s = 0.01;
constexpr double kSettled_s = 8.0;
/// Log-likelihood ratio that est::PathConsistency requires before it contradicts a pose.
constexpr double kNats = 16.0;

/// Mean square of an honest hover's path, high-passed by s^3 / (s + a)^3, m^2, both axes together.
double moved_m2(const lab::experiments::Trace& trace, double a_per_s) {
  std::array<std::array<double, 3>, 2> slow_m{};
  double sum_m2 = 0.0;
  int count = 0;
  for (const lab::experiments::TracePoint& point : trace) {
    for (std::size_t axis = 0; axis < 2; ++axis) {
      double left_m = point.position_m[axis] - trace.front().position_m[axis];
      for (double& slow : slow_m[axis]) {
        slow += (left_m - slow) * a_per_s * kTick_s;
        left_m -= slow;
      }
      sum_m2 += point.t_s > kSettled_s ? left_m * left_m : 0.0;
    }
    count += point.t_s > kSettled_s ? 1 : 0;
  }
  return sum_m2 / count;
}

/// Noise of the path computed from the specific force, m, one axis: the rotors' 0.1 m/s^2 at 100 Hz, a slow attitude
/// error of 0.02/3 m/s^2, and 0.7 mm of the observer's position.
double noise_m(double a_per_s) {
  const double rotors_m = 0.1 * std::sqrt(kTick_s / (16.0 * a_per_s * a_per_s * a_per_s));
  const double attitude_m = 0.27 / (a_per_s * a_per_s) * 0.02 / 3.0;
  return std::sqrt(rotors_m * rotors_m + attitude_m * attitude_m + 0.0007 * 0.0007);
}

/// Information per second for a detector that knows the lie in advance, at the best high-pass frequency. @param share
/// of the path that is false.
double nats_per_s(double share) {
  double best = 0.0;
  for (const double a_per_s : {0.75, 1.5, 3.0}) {
    double most = 0.0;
    for (int seed = 1; seed <= 4; ++seed) {
      most = std::max(most, moved_m2(flown_without_fault({}, seed).trace, a_per_s));
    }
    const double sigma_m = noise_m(a_per_s);
    best = std::max(best, a_per_s * share * share * most / (2.0 * sigma_m * sigma_m));
  }
  return best;
}

TEST(CalmHover, TellsTooLittleOfAFrameThatIsTurnedByTwentyDegrees) {
  RecordProperty("promise", "R14");
  const double share = 2.0 * std::sin(10.0 * std::numbers::pi / 180.0);
  const double standing = nats_per_s(1.0);
  const double turned = nats_per_s(share);
  RecordProperty("figure.information.turn20", printed("%.1f nats/s | %.1f s", turned, kNats / turned));
  RecordProperty("figure.information.standing", printed("%.1f nats/s | %.1f s", standing, kNats / standing));
  EXPECT_GT(kNats / turned, 3.0) << "enough information for a promise of 3 s, which must then be given";
}

/// Slow error of the attitude as an acceleration, and its duration, from measured logs (est::PathConsistency).
constexpr double kAttitude_m_s2 = 0.02, kAttitudeLasts_s = 2.0;
constexpr double kRotors_m_s2 = 0.1;

/// Speed to which a drift of the pose can grow in this time, at a constant rate, before a detector has enough
/// information that knows the drift, its beginning and the force's offset in advance. Matched filter: the energy of the
/// false acceleration over the noise density gives E / 2 S = nats.
double unseen_drift_m_s(double grows_for_s) {
  const double density =
      2.0 * kAttitudeLasts_s * kAttitude_m_s2 * kAttitude_m_s2 + kTick_s * kRotors_m_s2 * kRotors_m_s2;
  return std::sqrt(2.0 * kNats * density * grows_for_s);
}

TEST(CalmHover, TellsTooLittleOfADriftThatFadesIn) {
  RecordProperty("promise", "R14");
  RecordProperty("figure.information.drift", printed("%.2f m/s | %.2f m/s | %.2f m/s", unseen_drift_m_s(1.0),
                                                     unseen_drift_m_s(4.0), unseen_drift_m_s(10.0)));
  EXPECT_GT(unseen_drift_m_s(4.0), 0.3)
      << "enough information for a promise of 2 m at 0.3 m/s, which must then be given";
}

}  // namespace
}  // namespace m100::scenario
