// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest-spi.h>
#include <gtest/gtest.h>

#include <functional>

#include "host_tests/scenario/program/stall_meter.h"

namespace m100::scenario {

/// Telemetry is dead after 0.5 s (safety::Limits), and four processes take part in a test one after the other:
/// autopilot, program, backup process and the test itself. If the machine keeps each waiting for a quarter of that
/// time, the flight may end rightly.
constexpr double kStall_s = 0.5 / 4.0;
constexpr int kAttempts = 5;

/// Judges programs in real time. A failure on a machine that stalled says nothing about the programs: it counts only if
/// no wait reached kStall_s; otherwise `begin_again` clears up and `flight` is repeated. If the machine stalled in all
/// attempts, the test is skipped with a message. The same promises are also tested in simulated time
/// (scenario.authority).
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
  GTEST_SKIP() << "the machine stalled in each of " << kAttempts << " attempts, in the last for " << stalled_s << " s";
}

}  // namespace m100::scenario
