// SPDX-License-Identifier: BSD-3-Clause
// The monitor in flight, with fixed memory: supervisor and log get the channel that has left its model, and the size.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>

#include "firmware/mpc/generated/gain_table.h"
#include "firmware/safety/failsafe.h"
#include "host_tests/lab/experiments/flight.h"
#include "host_tests/lab/logs/formats/ulog.h"
#include "host_tests/lab/loop/aligned_log.h"

namespace m100::lab::loop {
namespace {

constexpr auto kNominal = static_cast<double>(safety::FailsafeState::kNominal);

struct Seen {
  double share = 0.0;    ///< of the flown ticks in which the sign was set
  double largest = 0.0;  ///< largest ratio of residual to expected residual, any channel
  double flown_s = 0.0;  ///< time in the nominal state
};

Seen fly_with(const sim::Plant& plant, const std::string& course, safety::FailsafeCondition sign,
              const std::string& name) {
  experiments::FlightPlan plan;
  plan.plant = plant;
  plan.vehicle = companion::as_file(mpc::generated::kVehicle);
  plan.course = course;
  plan.duration_s = 40.0;
  plan.seed = 5;
  plan.keep_log = true;
  const experiments::FlightResult flight = experiments::fly(plan);
  const std::string path = (std::filesystem::path(::testing::TempDir()) / (name + ".ulg")).string();
  static_cast<void>(load_flown(flight, path));
  const auto log = logs::open_ulog(path);
  const std::vector<double> facts = log->column("tick.facts", "a test").values;
  const std::vector<double> residual = log->column("tick.residual", "a test").values;
  const std::vector<double> failsafe_state = log->column("tick.state", "a test").values;
  const auto flown = static_cast<double>(std::count(failsafe_state.begin(), failsafe_state.end(), kNominal));
  Seen seen{.flown_s = flown * core::seconds<double>(core::kTickPeriod)};
  for (std::size_t k = 0; k < facts.size(); ++k) {
    if (failsafe_state[k] != kNominal) {
      continue;
    }
    const auto set = static_cast<safety::FailsafeCondition>(static_cast<std::uint32_t>(facts[k]));
    seen.share += all(set, sign) ? 1.0 / flown : 0.0;
    seen.largest = std::max(seen.largest, residual[k]);
  }
  return seen;
}

sim::Plant as_the_vehicle_file() {
  sim::Plant believed = sim::measured_plant();
  believed.roll = mpc::generated::kVehicle.roll;
  believed.pitch = mpc::generated::kVehicle.pitch;
  believed.climb = mpc::generated::kVehicle.climb;
  believed.yaw_rate = mpc::generated::kVehicle.yaw_rate;
  return believed;
}

// Catches a monitor with false alarms in healthy flights.
TEST(ResidualMonitorInFlight, SaysNothingInAHealthyFlight) {
  RecordProperty("promise", "R17");
  using safety::FailsafeCondition;
  const std::string course = excitation(5, 40.0);
  for (const FailsafeCondition sign :
       {FailsafeCondition::kRollModelMismatch, FailsafeCondition::kPitchModelMismatch,
        FailsafeCondition::kYawRateModelMismatch, FailsafeCondition::kClimbModelMismatch}) {
    const Seen believed = fly_with(as_the_vehicle_file(), course, sign, "as_believed");
    EXPECT_EQ(believed.share, 0.0) << static_cast<std::uint32_t>(sign);
    EXPECT_GT(believed.flown_s, 39.9) << "the healthy flight ended early";
    EXPECT_EQ(fly_with(sim::measured_plant(), course, sign, "measured").share, 0.0) << static_cast<std::uint32_t>(sign);
  }
}

// Catches a monitor whose result is reported nowhere. Each change must be noticed on its own axis, and on no other.
TEST(ResidualMonitorInFlight, TheLogSaysWhichChannelAndHowMuch) {
  RecordProperty("promise", "R17");
  const std::string course = excitation(5, 40.0);
  const sim::Plant believed = as_the_vehicle_file();
  sim::Plant late = believed;
  late.roll.transport_delay_s += 0.06;
  sim::Plant weak = believed;
  weak.roll.scale_per_count *= 0.7;
  sim::Plant strong = believed;
  strong.roll.scale_per_count *= 1.3;
  for (const sim::Plant& other : {late, weak, strong}) {
    const Seen roll = fly_with(other, course, safety::FailsafeCondition::kRollModelMismatch, "roll_left");
    EXPECT_GT(roll.share, 0.2);
    EXPECT_GT(roll.largest, 1.0);
    EXPECT_EQ(fly_with(other, course, safety::FailsafeCondition::kPitchModelMismatch, "pitch_stayed").share, 0.0);
  }
}

// The measured plant has its trims at 1080 and 998, the vehicle file at 1024; hover must show the difference.
TEST(ResidualMonitorInFlight, TheLogSaysThatTheTrimIsNotTheVehicleFiles) {
  EXPECT_GT(fly_with(sim::measured_plant(), "", safety::FailsafeCondition::kTrimDrifted, "other_trim").share, 0.4);
  EXPECT_EQ(fly_with(as_the_vehicle_file(), "", safety::FailsafeCondition::kTrimDrifted, "same_trim").share, 0.0);
}

}  // namespace
}  // namespace m100::lab::loop
