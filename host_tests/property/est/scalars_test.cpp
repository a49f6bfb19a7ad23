// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <string>

#include "host_tests/property/est/long_run.h"

namespace m100::est {
namespace {

#ifndef M100_HOURS
#define M100_HOURS (1.0 / 6.0)
#endif

void print(const char* name, const ScalarReport& r) {
  std::printf(
      "%-6s from double: p %.2g rms %.2g max m, v %.2g rms m/s, d %.2g rms %.2g max m/s^2; "
      "not positive %ld, poses refused %ld\n",
      name, r.position_rms_m, r.position_max_m, r.velocity_rms_m_s, r.disturbance_rms_m_s2, r.disturbance_max_m_s2,
      r.not_positive, r.refused);
}

/// The cells of a row on a page. The figures' names end with the arithmetic; the 24-hour run has its own names.
std::string cells(const ScalarReport& r) {
  std::array<char, 120> text{};
  std::snprintf(text.data(), text.size(), "%.1e / %.1e m | %.1e / %.1e m/s^2", r.position_rms_m, r.position_max_m,
                r.disturbance_rms_m_s2, r.disturbance_max_m_s2);
  return text.data();
}
constexpr const char* kLength = M100_HOURS < 1.0 ? "short." : "day.";

// Catches a fixed point that is too coarse for the smallest covariances, a rounding that drifts, and a loss of
// positivity that only a long flight shows.
TEST(EkfScalars, StayWithinMicrometresOfDoubleAndPositive) {
  RecordProperty("promise", "R11");
  const LongRunReport report = long_run(M100_HOURS, 20261121U);
  std::printf("%.2f h, filter against the truth: d %.3f m/s^2 rms\n", M100_HOURS, report.disturbance_error_rms_m_s2);
  print("fixed", report.fixed);
  print("float", report.single);
  RecordProperty("figure.est." + std::string(kLength) + "fixed", cells(report.fixed));
  RecordProperty("figure.est." + std::string(kLength) + "float", cells(report.single));
  EXPECT_LE(report.fixed.position_rms_m, 1e-6);
  EXPECT_LE(report.fixed.disturbance_rms_m_s2, 1e-5);
  EXPECT_EQ(report.fixed.not_positive, 0);
  EXPECT_EQ(report.single.not_positive, 0);
  EXPECT_EQ(report.not_positive_double, 0);
  // Tolerance: a float resolves 2 m to 2.4e-7 m, which is larger than the effect of the covariance.
  EXPECT_LE(report.single.position_rms_m, 2e-6);
  EXPECT_LE(report.single.disturbance_rms_m_s2, 3e-5);
  EXPECT_LE(report.disturbance_error_rms_m_s2, 0.5);
}

}  // namespace
}  // namespace m100::est
