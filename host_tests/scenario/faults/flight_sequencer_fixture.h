// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include "firmware/companion/fly/flight_sequencer.h"
#include "host_tests/scenario/faults/fault_bench.h"
#include "host_tests/scenario/faults/message_recorder.h"

namespace m100::scenario {

/// The operator's part of m100 fly with the whole flight controller, on both channels.
class FlightSequencerTest : public ::testing::TestWithParam<link::Channel> {
 protected:
  void begin(const companion::FlightRequest& wishes, const core::Fence& fence = {},
             const sim::Plant& plant = sim::measured_plant(), const link::LeverArm& stated_b_m = {},
             const sim::WorldOptions& options = {.seed = 5}) {
    bench_.emplace(GetParam(), 0, fence, plant, stated_b_m, options);
    sequencer_.emplace(wishes, app::kDefaultFlight, bench_->controller(), bench_->course(), heard_);
  }
  bool tick() {
    bench_->tick();
    const bool goes_on = sequencer_->tick(bench_->world().now(), input_);
    input_.toggle_control = false;
    return goes_on;
  }
  /// @returns the time until the condition was true; empty if it was not in time, or if the program ended before.
  template <typename Condition>
  std::optional<core::Duration> until(const Condition& condition, core::Duration at_most) {
    const core::TimePoint from = bench_->world().now();
    while (!condition()) {
      if (ended_ || bench_->world().now() - from >= at_most) {
        return std::nullopt;
      }
      ended_ = !tick();
    }
    return bench_->world().now() - from;
  }
  bool fly_for(core::Duration time) {
    const auto flies = [&] { return bench_->failsafe_state() == FailsafeState::kNominal; };
    if (!until(flies, seconds(20))) {
      return false;
    }
    (void)until([] { return false; }, time);
    return flies();
  }
  static core::Vector<double, 3> bench_start() { return FaultBench().world().vehicle().state().position_w_m; }
  bool is_pilots() {
    return !bench_->world().autopilot().client_in_control() && !bench_->world().autopilot().virtual_rc_on();
  }

  std::optional<FaultBench> bench_;
  MessageRecorder heard_;
  std::optional<companion::FlightSequencer> sequencer_;
  companion::OperatorInput input_;
  bool ended_ = false;
};

}  // namespace m100::scenario
