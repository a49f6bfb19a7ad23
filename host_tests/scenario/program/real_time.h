// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest-spi.h>
#include <gtest/gtest.h>

#include <functional>

#include "host_tests/scenario/program/stall_meter.h"

namespace m100::scenario {

/// Telemetry is dead after 0.5 s (safety::Limits), and four processes stand in line on its way into a test: autopilot,
/// program, keeper and the test itself. A machine that keeps each waiting for a quarter of it may end a flight, as it
/// must.
constexpr double kStall_s = 0.5 / 4.0;
constexpr int kAttempts = 5;

/// Programs in real time. What a flight shows on a machine that stalled says nothing about the programs: a failure
/// counts only where no wait reached kStall_s, else `begin_again` clears up and `flight` is flown anew. Where the
/// machine stalled in all attempts the test is skipped, and says so; the same promises are held in simulated time too
/// (scenario.sticks).
template <typename Meter = StallMeter>
void judge_in_real_time(const std::function<void()>& begin_again, const std::function<void()>& flight) {
  double stalled_s = 0.0;
  for (int attempt = 1; attempt <= kAttempts; ++attempt) {
    ::testing::TestPartResultArray seen;
    {
      Meter machine;
      const ::testing::ScopedFakeTestPartResultReporter held(
          ::testing::ScopedFakeTestPartResultReporter::INTERCEPT_ALL_THREADS, &seen);
      flight();
      stalled_s = machine.longest_s();
    }
    bool failed = false;
    for (int i = 0; i < seen.size(); ++i) {
      const ::testing::TestPartResult& result = seen.GetTestPartResult(i);
      failed = failed || result.failed();
      if (result.failed() && stalled_s < kStall_s) {
        ADD_FAILURE_AT(result.file_name(), result.line_number()) << result.message();
      }
    }
    if (!failed || stalled_s < kStall_s) {
      return;
    }
    begin_again();
  }
  GTEST_SKIP() << "in each of " << kAttempts << " attempts the machine stalled, in the last for " << stalled_s << " s";
}

}  // namespace m100::scenario
