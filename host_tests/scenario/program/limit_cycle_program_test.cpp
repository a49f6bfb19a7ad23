// SPDX-License-Identifier: BSD-3-Clause
// An aircraft with a limit cycle, with both programs in simulated time: the messages to the operator, the result, the
// log, and the rest of the flight.
#include "firmware/companion/files/recorded_flight.h"
#include "firmware/safety/failsafe.h"
#include "host_tests/scenario/program/world_fixture.h"

namespace m100::scenario {
namespace {

class LimitCycleFlight : public WorldTest {
 protected:
  /// Hovers in the world of this plant file. @returns the exit code.
  int hover(const std::string& plant, const std::string& hold_s = "20") {
    return fly_in_world(plant, {"--hold", hold_s});
  }
  /// Number of ticks with this sign in the log.
  std::size_t ticks_with(safety::FailsafeCondition sign) const {
    std::size_t count = 0;
    for (const auto& tick : companion::read_flight(log.string()).ticks) {
      count += any(static_cast<safety::FailsafeCondition>(tick.record.facts), sign) ? 1U : 0U;
    }
    return count;
  }
};

// 40 % more gain and 150 ms more delay than in the vehicle file.
constexpr char kSwings[] =
    "[axis.roll]\nscale_rad_per_count = 1.292e-3\ntransport_delay_s = 0.1604\n"
    "[axis.pitch]\nscale_rad_per_count = 1.291e-3\ntransport_delay_s = 0.15\n";
TEST_F(LimitCycleFlight, IsSaidByNameAndFlownOnByTheCalmLaw) {
  RecordProperty("promise", "R17");
  ASSERT_EQ(hover(kSwings), 1) << "a flight that swung is no success: " << error();
  EXPECT_NE(all_said().find("swinging: the aircraft swings by itself, by "), std::string::npos) << all_said();
  EXPECT_NE(all_said().find("Stop and land"), std::string::npos);
  const Json flown = reported();
  ASSERT_TRUE(flown.contains("swinging")) << flown.dump(1);
  EXPECT_GT(flown["swinging"]["height_rad"].get<double>(), 0.1);
  EXPECT_NEAR(flown["swinging"]["frequency_hz"].get<double>(), 1.4, 0.6);
  EXPECT_EQ((flown["failsafe"].end() - 1)->at("cause"), "neutral_over")
      << "control must go back because --hold was over";
  EXPECT_GT(ticks_with(safety::FailsafeCondition::kLimitCycle), 500U);
  EXPECT_EQ(ticks_with(safety::FailsafeCondition::kLimitCyclePersists), 0U);
}

// Under the fallback law the aircraft gets 1.9 times the gain and 0.13 s more delay.
TEST_F(LimitCycleFlight, ThatGoesOnEndsTheFlightByName) {
  RecordProperty("promise", "R12");
  EXPECT_EQ(hover(std::string(kSwings) +
                      "[change]\nat_s = 20.0\n"
                      "\"axis.roll.scale_rad_per_count\" = 2.45e-3\n\"axis.pitch.scale_rad_per_count\" = 2.45e-3\n"
                      "\"axis.roll.transport_delay_s\" = 0.29\n\"axis.pitch.transport_delay_s\" = 0.28\n",
                  "60"),
            1);
  EXPECT_NE(all_said().find("failsafe: nominal to level, swinging: "), std::string::npos) << all_said();
  EXPECT_GT(ticks_with(safety::FailsafeCondition::kLimitCyclePersists), 0U);
}

TEST_F(LimitCycleFlight, IsNotSaidOfAHealthyHover) {
  RecordProperty("promise", "R17");
  ASSERT_EQ(hover("[air]\nlinear_drag_per_s = 0.3\nwind_m_s = [3.0, 4.0, 0.0]\nturbulence_m_s = 0.8\n"), 0) << error();
  EXPECT_EQ(all_said().find("swing"), std::string::npos) << all_said();
  EXPECT_FALSE(reported().contains("swinging"));
  EXPECT_EQ(ticks_with(safety::FailsafeCondition::kLimitCycle), 0U);
}

}  // namespace
}  // namespace m100::scenario
