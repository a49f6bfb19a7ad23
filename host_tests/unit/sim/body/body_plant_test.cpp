// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/body/body_plant.h"

#include <gtest/gtest.h>

#include "host_tests/refusal.h"
#include "host_tests/sim/world/plant_file.h"

namespace m100::sim {
namespace {

const BodyChoice kNoBody{};
const BodyChoice kStarted{.body = "identified", .command = "world {port} {wind}"};
const BodyChoice kRuns{.body = "json:127.0.0.1:9002", .command = ""};

std::string refusal(const BodyChoice& body, const std::string& text) {
  return host_tests::refusal_by<companion::FileError>([&] { (void)parse_plant(body, text, "p.toml", ""); });
}

TEST(BodyPlant, RefusesWhatThePhysicsProgramHasItself) {
  for (const char* const text :
       {"[axis.roll]\nnatural_frequency_rad_s = 6", "[axis.pitch]\ndamping_ratio = 0.6",
        "[axis.roll]\ntransport_delay_s = 0.1", "[axis.roll]\nlead_zero_s = 0.1", "[axis.roll]\nrate_limit_rad_s = 1",
        "[axis.yaw_rate]\nrate_limit_rad_s2 = 1", "[axis.climb]\nrate_limit_m_s2 = 1",
        "[axis.yaw_rate]\ntime_constant_s = 0.1", "[air]\nlinear_drag_per_s = 0", "[air]\nturbulence_m_s = 1",
        "[air]\nattitude_disturbance_rad = 0", "[payload]\nmass_kg = 0.5", "[vehicle]\nmass_kg = 3",
        "[battery]\nsag = 0.1"}) {
    const std::string wrong = refusal(kStarted, text);
    EXPECT_TRUE(wrong.starts_with("p.toml:2: '")) << text << ": " << wrong;
    EXPECT_NE(wrong.find("has no effect on a body"), std::string::npos) << wrong;
    EXPECT_EQ(refusal(kNoBody, text), "") << text;
  }
}

TEST(BodyPlant, TakesWhatIsTheSticksTheSensorsAndTheLinks) {
  for (const char* const text :
       {("[axis.roll]\ntrim_counts = 20\nscale_rad_per_count = 9e-4\ndead_zone_counts = 5\ndead_zone_shape = \"jump\"\n"
         "stick_exponent = 1.2\nbacklash_counts = 3\ncross_axis = 0.1\ngain_asymmetry = 1.1\nsaturation_rad = 0.3\n"
         "gain_drift_per_minute = 0.1\nsource = \"a guess\""),
        "[pose]\nrate_hz = 50\nphase = \"locked\"", "[sensors]\nimu_offset_m_s2 = 0.1\npose_noise_m = 0.002",
        "[link]\ncommand_delay_s = 0.03", "[autopilot]\nrate_gain_per_s = 15", "[battery]\nstart_percent = 50",
        "[change]\nat_s = 9\n\"axis.roll.trim_counts\" = 5"}) {
    EXPECT_EQ(refusal(kStarted, text), "") << text;
    EXPECT_EQ(refusal(kRuns, text), "") << text;
  }
}

TEST(BodyPlant, HasAWindOnlyWhereItsCommandIsGivenIt) {
  const std::string text = "[air]\nwind_m_s = [1, 2, 0]";
  EXPECT_EQ(refusal(kStarted, text), "");
  EXPECT_NE(refusal(kRuns, text).find("'air.wind_m_s'"), std::string::npos);
  EXPECT_NE(refusal({.body = "identified", .command = "world {port}"}, text).find("{wind}"), std::string::npos);
}

TEST(BodyPlant, ChangesItsSticksOnly) {
  for (const char* const change :
       {"\"axis.roll.lead_zero_s\" = 0.1", "\"air.linear_drag_per_s\" = 1", "\"air.wind_m_s\" = [1, 0, 0]"}) {
    const std::string text = std::string("[change]\nat_s = 9\n") + change;
    EXPECT_TRUE(refusal(kStarted, text).starts_with("p.toml:3: 'change.a")) << refusal(kStarted, text);
    EXPECT_EQ(refusal(kNoBody, text), "") << text;
  }
}

TEST(BodyPlant, RefusesWhatOnlyABodyHas) {
  EXPECT_TRUE(refusal(kNoBody, "[autopilot]\nbarometer_s = 3").starts_with("p.toml:2: 'autopilot.barometer_s'"));
  EXPECT_THROW(plant_of_options(kRuns, "", "vehicle.toml"), PhysicsError);
  EXPECT_THROW(parse_plant(kStarted, "# nothing", "p.toml", "vehicle.toml"), PhysicsError);
}

double roll_after(BodySticks& sticks, double for_s) {
  for (double t_s = 0.0; t_s < for_s; t_s += 0.0025) {
    sticks.advance(0.0025);
  }
  return sticks.output().roll_rad;
}

TEST(BodySticks, HaveNoDynamicsAndTheLinksDelay) {
  Plant plant = parse_plant(
      "[axis.roll]\ntrim_counts = 10\nscale_rad_per_count = 1e-3\ndead_zone_counts = 0\n"
      "[link]\ncommand_delay_s = 0.02\n",
      "p.toml");
  BodySticks sticks(plant);
  sticks.command(StickInput{.roll_vrc = 1024.0 + 110.0});
  EXPECT_EQ(roll_after(sticks, 0.02), 0.0);
  EXPECT_NEAR(roll_after(sticks, 0.005), 0.1, 1e-12);
}

TEST(BodySticks, LeakIntoTheOtherAxis) {
  const Plant plant = parse_plant(
      "[axis.roll]\ntrim_counts = 0\ncross_axis = 0.5\n"
      "[axis.pitch]\nscale_rad_per_count = 1e-3\ntrim_counts = 0\ndead_zone_counts = 0\n",
      "p.toml");
  BodySticks sticks(plant);
  sticks.command(StickInput{.pitch_vrc = 1124.0});
  EXPECT_NEAR(roll_after(sticks, 0.1), 0.05, 1e-12);
}

TEST(BodySticks, ChangeWhenTheWorldsTimeHasCome) {
  const Plant plant = parse_plant(
      "[axis.roll]\nscale_rad_per_count = 1e-3\ntrim_counts = 0\ndead_zone_counts = 0\n"
      "[change]\nat_s = 1\n\"axis.roll.trim_counts\" = 50\n",
      "p.toml");
  BodySticks sticks(plant);
  EXPECT_EQ(roll_after(sticks, 3.0), 0.0);  // taking off is before the world's time
  sticks.start_time();
  EXPECT_EQ(roll_after(sticks, 0.99), 0.0);
  EXPECT_NEAR(roll_after(sticks, 0.1), -0.05, 1e-12);
}

}  // namespace
}  // namespace m100::sim
