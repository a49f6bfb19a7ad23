// SPDX-License-Identifier: BSD-3-Clause
// A height of the poses that drifts, and an autopilot that says "on the ground", in flights of the whole controller
// (promise R18).
#include <gtest/gtest.h>

#include "host_tests/scenario/sensor_faults/sensor_fault_bench.h"

namespace m100::scenario {
namespace {

constexpr double kDriftsAt_s = 5.0;
constexpr double kCeiling_m = 4.0;

void lands(protocol::Telemetry& telemetry, sim::SensorFaultState<protocol::Telemetry>&, double) {
  telemetry.flight_status = protocol::FlightStatus::kStandby;
}
constexpr sim::SensorFault kLands{"lands", "the flight status says on the ground", 0.0, "", nullptr, lands};

struct Outcome {
  double highest_m = 0.0;
  double touchdown_s = -1.0;   ///< negative: none
  double touchdown_m_s = 0.0;  ///< vertical speed
  double given_back_s = -1.0;  ///< negative: not before the end
  std::string descent;
};

Outcome flown(const sim::SensorFault& fault, double size, double duration_s, int seed = 1) {
  lab::experiments::FlightPlan plan = plan_in(Air::kCalm, seed);
  plan.duration_s = duration_s;
  plan.course = size > 0.0 ? "step 0 0 0 0 3\nstep 0 0 -0.8 0 120\n" : "";  // so low that the check sees it too late
  plan.flight_file = companion::parse_flight(
      "[fence]\nx_m = [-6, 6]\ny_m = [-6, 6]\nz_m = [0.3, 4]\n[wind]\nclass_m_s = 5\n", "flight.toml");
  plan.disturb = strikes_at(kDriftsAt_s, fault, size);
  const lab::experiments::FlightResult result = lab::experiments::fly(plan);
  Outcome outcome{.descent = result.descent};
  for (const lab::experiments::TracePoint& point : result.trace) {
    outcome.highest_m = std::max(outcome.highest_m, point.position_m[2]);
    if (outcome.touchdown_s < 0.0 && point.position_m[2] <= 0.0) {
      outcome.touchdown_s = point.t_s;
      outcome.touchdown_m_s = result.touchdown_speed_m_s;
    }
    if (point.t_s > kDriftsAt_s && point.failsafe_state == static_cast<int>(safety::FailsafeState::kSilent)) {
      outcome.given_back_s = point.t_s;
      break;
    }
  }
  return outcome;
}

TEST(Ground, AFlightStatusOnTheGroundEndsControlWithinASecond) {
  RecordProperty("promise", "R18");
  const Outcome outcome = flown(kLands, 0.0, 20.0);
  EXPECT_EQ(outcome.descent, "on_ground");
  EXPECT_GE(outcome.given_back_s, kDriftsAt_s + 0.4);
  EXPECT_LE(outcome.given_back_s, kDriftsAt_s + 1.0);
}

// Catches a climb of a healthy aircraft that is called wrong: the measured flight leaves the climb's gain open by 30 %.
TEST(Ground, AStepInHeightIsFlownWithAnotherClimbGain) {
  RecordProperty("promise", "R17");
  for (const auto& [rise_m, seed] : {std::pair{1.0, 10}, {1.5, 1}, {2.0, 2}, {2.0, 3}, {4.0, 10}}) {
    lab::experiments::FlightPlan plan = plan_in(Air::kCalm, seed);
    plan.course = "step 0 0 0 0 3\nstep 0 0 " + std::to_string(rise_m) + " 0 7\nstep 0 0 0 0 7\n";
    plan.duration_s = 17.0;
    const lab::experiments::FlightResult result = lab::experiments::fly(plan);
    EXPECT_FALSE(result.contradicted) << rise_m << " m, seed " << seed << ": " << result.descent;
  }
}

// Catches contacts that are counted too slowly: many short touches (seed 14), hops of 1.3 s in LEVEL (6), 1.6 s (47).
TEST(Ground, AHeightThatDriftsEndsInTheAirOrGently) {
  RecordProperty("promise", "R18");
  for (const auto& [rise_m_s, seed] : {std::pair{0.03, 14}, {0.03, 47}, {0.05, 6}, {0.08, 1}, {-0.04, 1}, {-0.07, 1}}) {
    const Outcome outcome = flown(*sim::find_sensor_fault("rise"), rise_m_s, 90.0, seed);
    SCOPED_TRACE(std::to_string(rise_m_s) + " m/s: " + outcome.descent + " at " + std::to_string(outcome.given_back_s) +
                 " s, touchdown at " + std::to_string(outcome.touchdown_s) + " s, highest " +
                 std::to_string(outcome.highest_m));
    EXPECT_GT(outcome.given_back_s, 0.0);
    EXPECT_LT(outcome.highest_m, kCeiling_m + 1.3);
    EXPECT_EQ(outcome.touchdown_s >= 0.0, rise_m_s > 0.0);
    if (outcome.touchdown_s >= 0.0) {
      EXPECT_LT(std::abs(outcome.touchdown_m_s), 0.5);
      EXPECT_LT(outcome.given_back_s, outcome.touchdown_s + 1.5);
    }
  }
}

}  // namespace
}  // namespace m100::scenario
