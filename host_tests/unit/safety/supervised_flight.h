// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include "firmware/safety/supervisor.h"

namespace m100::safety {

inline Observation good(core::TimePoint now) {
  using std::chrono::milliseconds;
  return {.now = now,
          .estimate = {.pose_age = milliseconds(20), .healthy = true},
          .link = {.telemetry_age = milliseconds(5), .in_control = true, .mode_f = true}};
}

/// A supervisor in flight, run one tick at a time.
struct SupervisedFlight {
  core::TimePoint now{};
  Supervisor<double> supervisor{Limits{}, Envelope{}};
  ctl::Command<double> law;  ///< what the law commands, unless a tick says otherwise

  explicit SupervisedFlight(const ctl::Command<double>& wanted = {}) : law(wanted) {
    for (int i = 0; i < 20; ++i) {
      Observation seen = good(now);
      seen.orders.engages = i == 15;
      tick(seen);
    }
    EXPECT_EQ(supervisor.failsafe_state(), FailsafeState::kNominal);
  }
  SupervisedCommand<double> tick(const Observation& seen) { return tick(seen, law); }
  SupervisedCommand<double> tick(Observation seen, const ctl::Command<double>& wanted,
                                 const ctl::Command<double>& settled = {}) {
    now += std::chrono::milliseconds(10);
    seen.now = now;
    const CommandSource passes = supervisor.update_failsafe(wanted, seen);
    return supervisor.limit_command(passes, passes == CommandSource::kLaw ? wanted : settled, 0.01);
  }
  /// Runs one tick at the time `after` later than the previous tick.
  FailsafeState later(core::Duration after, const Observation& seen) {
    now += after - std::chrono::milliseconds(10);
    return tick(seen).failsafe_state;
  }
};

}  // namespace m100::safety
