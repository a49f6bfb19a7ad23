// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/plant_file.h"

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
  EXPECT_EQ(plant.roll.natural_frequency_rad_s, 0.0);  // the section replaces the measured axis as a whole
  EXPECT_EQ(plant.roll.trim_counts, 0.0);
  EXPECT_EQ(plant.roll.dead_zone_shape, model::DeadZoneShape::kJump);
  EXPECT_EQ(plant.pitch.trim_counts, measured_plant().pitch.trim_counts);
  EXPECT_EQ(plant.air.wind_m_s.y(), -2.5);
  EXPECT_EQ(plant.air.linear_drag_per_s, measured_plant().air.linear_drag_per_s);
  EXPECT_EQ(plant.payload.slung_length_m, 1.5);
  EXPECT_EQ(plant.sensors.pose_delay_s, 0.05);
  EXPECT_EQ(plant.link.baud, 230400.0);
  EXPECT_EQ(plant.battery.sag, 0.2);
}

struct Bad {
  const char* name;
  const char* text;
  const char* says;
};
class BadPlantFile : public ::testing::TestWithParam<Bad> {};

TEST_P(BadPlantFile, IsRefusedInOneLineThatNamesThePlace) {
  try {
    (void)parse_plant(GetParam().text, "p.toml");
    FAIL() << "was accepted";
  } catch (const PlantFileError& error) {
    EXPECT_NE(std::string(error.what()).find(GetParam().says), std::string::npos) << error.what();
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
  }
}
INSTANTIATE_TEST_SUITE_P(
    Table, BadPlantFile,
    ::testing::Values(Bad{"Empty", "", "p.toml: the file is empty"}, Bad{"NotToml", "[axis", "p.toml:1:"},
                      Bad{"UnknownSection", "[wind]\nx = 1\n", "p.toml:1: 'wind'"},
                      Bad{"UnknownKey", "[air]\n\nwnid_m_s = 1\n", "p.toml:3: 'air.wnid_m_s': unknown key"},
                      Bad{"UnknownAxis", "[axis.rol]\nx = 1\n", "'axis.rol': unknown axis"},
                      Bad{"Negative", "[axis.roll]\nscale_rad_per_count = 1e-3\ntime_constant_s = -0.1\n",
                          "p.toml:3: 'axis.roll.time_constant_s'"},
                      Bad{"NoOrder", "[axis.roll]\nscale_rad_per_count = 1e-3\n", "time_constant_s"},
                      Bad{"NoScale", "[axis.roll]\ntime_constant_s = 0.1\n", "scale_rad_per_count"},
                      Bad{"WindIsTwoNumbers", "[air]\nwind_m_s = [1, 2]\n", "three numbers"},
                      Bad{"NotANumber", "[battery]\nsag = nan\n", "p.toml:2: 'battery.sag'"}),
    [](const auto& tested) { return tested.param.name; });

}  // namespace
}  // namespace m100::sim
