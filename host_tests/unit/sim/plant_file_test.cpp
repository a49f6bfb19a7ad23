// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/world/plant_file.h"
#include "host_tests/refusal.h"
#include "host_tests/sim/world/base_plant.h"

#include <gtest/gtest.h>

namespace m100::sim {
namespace {

constexpr const char* kAxis = "[axis.roll]\nscale_rad_per_count = 9e-4\ntime_constant_s = 0.087\n";

TEST(PlantFile, ReadsEverySection) {
  const Plant plant = parse_plant(std::string(kAxis) +
                                      "transport_delay_s = 0.107\ndead_zone_counts = 10\ndead_zone_shape = \"jump\"\n"
                                      "backlash_counts = 3.0\ncross_axis = 0.1\n"
                                      "[air]\nwind_m_s = [1, -2.5, 0]\ngust_m_s = 1.0\ngust_hz = 0.3\n"
                                      "[payload]\nmass_kg = 0.5\nslung_length_m = 1.5\n"
                                      "[sensors]\npose_delay_s = 0.05\n[link]\nbaud = 230400\n[battery]\nsag = 0.2\n",
                                  "p.toml");
  EXPECT_EQ(plant.roll.time_constant_s, 0.087);
  EXPECT_EQ(plant.roll.natural_frequency_rad_s, 0.0);  // the time constant replaces the second order
  EXPECT_EQ(plant.roll.trim_counts, measured_plant().roll.trim_counts);
  EXPECT_EQ(plant.roll.dead_zone_shape, model::DeadZoneShape::kJump);
  EXPECT_EQ(plant.pitch.trim_counts, measured_plant().pitch.trim_counts);
  EXPECT_EQ(plant.air.wind_m_s.y(), -2.5);
  EXPECT_EQ(plant.air.linear_drag_per_s, measured_plant().air.linear_drag_per_s);
  EXPECT_EQ(plant.payload.slung_length_m, 1.5);
  EXPECT_EQ(plant.pose.latency_s, 0.05);
  EXPECT_EQ(plant.link.baud, 230400.0);
  EXPECT_EQ(plant.battery.sag, 0.2);
}

TEST(PlantFile, IsAListOfDifferences) {
  const Plant measured = measured_plant();
  const Plant same = parse_plant("# nothing\n", "p.toml");
  EXPECT_EQ(same.roll.natural_frequency_rad_s, measured.roll.natural_frequency_rad_s);
  EXPECT_EQ(same.climb.dead_zone_counts, measured.climb.dead_zone_counts);
  EXPECT_EQ(same.air.linear_drag_per_s, measured.air.linear_drag_per_s);

  const Plant one = parse_plant("[axis.roll]\ndead_zone_counts = 30\n", "p.toml");
  EXPECT_EQ(one.roll.dead_zone_counts, 30.0);
  EXPECT_EQ(one.roll.natural_frequency_rad_s, measured.roll.natural_frequency_rad_s);
  EXPECT_EQ(one.roll.transport_delay_s, measured.roll.transport_delay_s);
  EXPECT_EQ(one.pitch.dead_zone_counts, measured.pitch.dead_zone_counts);

  const Plant second = parse_plant("[axis.yaw_rate]\nnatural_frequency_rad_s = 5\ndamping_ratio = 0.7\n", "p.toml");
  EXPECT_EQ(second.yaw_rate.time_constant_s, 0.0);
  EXPECT_EQ(second.yaw_rate.dead_zone_counts, measured.yaw_rate.dead_zone_counts);
}

TEST(PlantFile, ZeroSwitchesAnEffectOff) {
  const Plant plant = parse_plant(
      "[axis.roll]\ndead_zone_counts = 0\ntransport_delay_s = 0\ngain_asymmetry = 0\nstick_exponent = 0\n"
      "[air]\nlinear_drag_per_s = 0\n",
      "p.toml");
  EXPECT_EQ(plant.roll.dead_zone_counts, 0.0);
  EXPECT_EQ(plant.roll.transport_delay_s, 0.0);
  EXPECT_EQ(plant.roll.gain_asymmetry, 1.0);  // its neutral value; zero would be an effect
  EXPECT_EQ(plant.roll.stick_exponent, 1.0);
  EXPECT_EQ(plant.air.linear_drag_per_s, 0.0);
}

TEST(PlantFile, ReadsTheSourceOfPoseUnderItsNewAndItsOldNames) {
  const Plant plant = parse_plant(
      "[pose]\nrate_hz = 240\nlatency_s = 0.07\njitter_s = 0.04\nburst_s = 0.08\nburst_per_s = 1\n"
      "clock_drift_ppm = -100\nphase = \"random\"\nreported_age = \"constant\"\nreported_age_s = 0.01\n"
      "noise_m = 0.002\nnoise_rad = 0.004\nquantum_m = 0.001\ndropout_per_s = 0.2\ndropout_s = 0.5\n",
      "p.toml");
  EXPECT_EQ(plant.pose.rate_hz, 240.0);
  EXPECT_EQ(plant.pose.latency_s, 0.07);
  EXPECT_EQ(plant.pose.jitter_s, 0.04);
  EXPECT_EQ(plant.pose.burst_s, 0.08);
  EXPECT_EQ(plant.pose.burst_per_s, 1.0);
  EXPECT_EQ(plant.pose.clock_drift_ppm, -100.0);
  EXPECT_EQ(plant.pose.phase, PosePhase::kRandom);
  EXPECT_EQ(plant.pose.reported_age, ReportedAge::kConstant);
  EXPECT_EQ(plant.pose.reported_age_s, 0.01);
  EXPECT_EQ(plant.pose.noise_m, 0.002);
  EXPECT_EQ(plant.pose.noise_rad, 0.004);
  EXPECT_EQ(plant.pose.quantum_m, 0.001);
  EXPECT_EQ(plant.pose.dropout_per_s, 0.2);
  EXPECT_EQ(plant.pose.dropout_s, 0.5);

  const Plant old = parse_plant(
      "[sensors]\npose_noise_m = 0.002\npose_yaw_noise_rad = 0.004\npose_delay_s = 0.07\npose_dropout_per_s = 0.2\n"
      "pose_dropout_s = 0.5\nattitude_noise_rad = 0.01\n",
      "p.toml");
  EXPECT_EQ(old.pose.noise_m, plant.pose.noise_m);
  EXPECT_EQ(old.pose.noise_rad, plant.pose.noise_rad);
  EXPECT_EQ(old.pose.latency_s, plant.pose.latency_s);
  EXPECT_EQ(old.pose.dropout_per_s, plant.pose.dropout_per_s);
  EXPECT_EQ(old.pose.dropout_s, plant.pose.dropout_s);
  EXPECT_EQ(old.sensors.attitude_noise_rad, 0.01);
}

// The default plant has no damping where it has no second order, so the reader must supply one. A device or a folder is
// refused, as everywhere.
TEST(PlantFile, ASecondOrderInThePlaceOfAFirstIsDampedAndAFileIsRegular) {
  const Plant plant = parse_plant("[axis.yaw_rate]\nnatural_frequency_rad_s = 6\n", "p.toml");
  EXPECT_EQ(plant.yaw_rate.time_constant_s, 0.0);
  EXPECT_EQ(plant.yaw_rate.damping_ratio, 1.0);
  const Plant later =
      changed(parse_plant("[change]\nat_s = 3\n\"axis.yaw_rate.natural_frequency_rad_s\" = 6\n", "p.toml"));
  EXPECT_EQ(later.yaw_rate.damping_ratio, 1.0);
  for (const char* const other : {"/dev/zero", "/"}) {
    EXPECT_THROW((void)load_plant(other), companion::FileError) << other;
  }
}

TEST(PlantFile, DiffersFromAVehicleFileWhereThatIsTheBase) {
  model::Vehicle vehicle;
  vehicle.roll = {.scale_per_count = 7e-4, .time_constant_s = 0.2, .lead_zero_s = 0.1, .backlash_counts = 4.0};
  vehicle.translation.linear_drag_per_s = 0.3;
  vehicle.translation.tilt_gain = 0.9;
  vehicle.translation.mass_kg = 2.9;
  const Plant plant = parse_plant("[axis.roll]\nbacklash_counts = 0\n", "p.toml", plant_of(vehicle));
  EXPECT_EQ(plant.roll.scale_per_count, 7e-4);
  EXPECT_EQ(plant.roll.lead_zero_s, 0.1);
  EXPECT_EQ(plant.roll.backlash_counts, 0.0);
  EXPECT_EQ(plant.air.linear_drag_per_s, 0.3);
  EXPECT_EQ(plant.air.tilt_gain, 0.9);
  EXPECT_EQ(plant.mass_kg, 2.9);
  EXPECT_EQ(plant.air.attitude_disturbance_rad, measured_plant().air.attitude_disturbance_rad);
}

TEST(PlantFile, ChangesAnyKeyOfAnAxisOrOfTheAirInMidFlight) {
  const Plant plant = parse_plant(
      "[air]\ngust_m_s = 2\n[change]\nat_s = 20\n\"axis.roll.dead_zone_counts\" = 30\n"
      "\"axis.pitch.time_constant_s\" = 0.2\naxis.climb.dead_zone_shape = \"jump\"\n\"air.gust_m_s\" = 0\n"
      "\"air.wind_m_s\" = [0, 5, 0]\n\"axis.yaw_rate.gain_asymmetry\" = 0\n",
      "p.toml");
  EXPECT_EQ(plant.change.at_s, 20.0);
  EXPECT_EQ(plant.roll.dead_zone_counts, measured_plant().roll.dead_zone_counts);
  const Plant after = changed(plant);
  EXPECT_EQ(after.roll.dead_zone_counts, 30.0);
  EXPECT_EQ(after.pitch.time_constant_s, 0.2);
  EXPECT_EQ(after.pitch.natural_frequency_rad_s, 0.0);
  EXPECT_EQ(after.climb.dead_zone_shape, model::DeadZoneShape::kJump);
  EXPECT_EQ(after.air.gust_m_s, 0.0);
  EXPECT_EQ(after.air.wind_m_s.y(), 5.0);
  EXPECT_EQ(after.yaw_rate.gain_asymmetry, 1.0);
}

struct Bad {
  const char* name;
  const char* text;
  const char* says;
};
class BadPlantFile : public ::testing::TestWithParam<Bad> {};

TEST_P(BadPlantFile, IsRefusedInOneLineThatNamesThePlace) {
  const std::string said =
      host_tests::refusal_by<companion::FileError>([] { (void)parse_plant(GetParam().text, "p.toml"); });
  EXPECT_NE(said.find(GetParam().says), std::string::npos) << said;
  EXPECT_EQ(said.find('\n'), std::string::npos);
}
INSTANTIATE_TEST_SUITE_P(
    Table, BadPlantFile,
    ::testing::Values(
        Bad{"Empty", "", "p.toml: the file is empty"}, Bad{"NotToml", "[axis", "p.toml:1:"},
        Bad{"UnknownSection", "[wind]\nx = 1\n", "p.toml:1: 'wind'"},
        Bad{"UnknownKey", "[air]\n\nwnid_m_s = 1\n", "p.toml:3: 'air.wnid_m_s': unknown key"},
        Bad{"UnknownAxis", "[axis.rol]\nx = 1\n", "'axis.rol': unknown axis"},
        Bad{"Negative", "[axis.roll]\nscale_rad_per_count = 1e-3\ntime_constant_s = -0.1\n",
            "p.toml:3: 'axis.roll.time_constant_s'"},
        Bad{"NoOrder", "[axis.roll]\nnatural_frequency_rad_s = 0\n", "p.toml:2: 'axis.roll.natural_frequency_rad_s'"},
        Bad{"TwoOrders", "[axis.roll]\ntime_constant_s = 0.1\nnatural_frequency_rad_s = 8\n",
            "give either time_constant_s or natural_frequency_rad_s"},
        Bad{"NoDamping", "[axis.roll]\ndamping_ratio = 0\n", "p.toml:2: 'axis.roll.damping_ratio'"},
        Bad{"DampingOfAFirstOrder", "[axis.yaw_rate]\ndamping_ratio = 0.3\n",
            "p.toml:2: 'axis.yaw_rate.damping_ratio': has no effect on a first order"},
        Bad{"ChangedDampingOfAFirstOrder", "[change]\nat_s = 3\n\"axis.yaw_rate.damping_ratio\" = 0.3\n",
            "p.toml:3: 'axis.yaw_rate.damping_ratio': has no effect on a first order"},
        Bad{"NoTimeConstant", "[axis.yaw_rate]\ntime_constant_s = 0\n", "p.toml:2: 'axis.yaw_rate.time_constant_s'"},
        Bad{"KeyAlias", "[sensors]\n\npose_noise_m = \"text\"\n", "p.toml:3: 'sensors.pose_noise_m'"},
        Bad{"AxisIsANumber", "axis = 3\n", "p.toml:1: 'axis': must be a table"},
        Bad{"NoScale", "[axis.roll]\nscale_rad_per_count = 0\n", "scale_rad_per_count"},
        Bad{"ChangeOfNothing", "[change]\nat_s = 3\n\"axis.rol.dead_zone_counts\" = 3\n",
            "p.toml:3: 'change.axis.rol.dead_zone_counts': is not a key"},
        Bad{"ChangeOfUnknownKey", "[change]\nat_s = 3\n\"air.gust\" = 3\n", "'change.air.gust'"},
        Bad{"ChangeAtNoTime", "[change]\n\"air.gust_m_s\" = 3\n", "'change.at_s': is missing"},
        Bad{"ChangeToNoDamping", "[change]\nat_s = 3\n\"axis.roll.damping_ratio\" = 0\n",
            "p.toml:3: 'axis.roll.damping_ratio'"},
        Bad{"NoMass", "[vehicle]\nmass_kg = 0\n", "vehicle.mass_kg"},
        Bad{"UnknownPhase", "[pose]\nphase = \"free\"\n", "must be \"random\" or \"locked\""},
        Bad{"UnknownAge", "[pose]\nreported_age = 3\n", "must be \"true\" or \"constant\" or \"none\""},
        Bad{"NoRate", "[pose]\nrate_hz = 0\n", "p.toml:2: 'pose.rate_hz'"},
        Bad{"OldAndNewName", "[pose]\nlatency_s = 0.1\n[sensors]\npose_delay_s = 0.2\n",
            "p.toml:4: 'sensors.pose_delay_s': is also given as pose.latency_s"},
        Bad{"WindIsTwoNumbers", "[air]\nwind_m_s = [1, 2]\n", "three numbers"},
        Bad{"NotANumber", "[battery]\nsag = nan\n", "p.toml:2: 'battery.sag'"}),
    [](const auto& tested) { return tested.param.name; });

}  // namespace
}  // namespace m100::sim
