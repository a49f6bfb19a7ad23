// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/logs/column_map.h"

#include "host_tests/unit/logs/log_files.h"

namespace m100::lab::logs {
namespace {

TEST(ColumnMap, ReadsNamesScalesAndExtras) {
  const ColumnMap map = parse_column_map(R"(
time = "t_s"
[signals]
stick_roll = { column = "rc_roll", offset = -1024, scale = 2 }
attitude_roll = "roll"
[extra]
battery = { column = "battery_v" }
)",
                                         "m.toml");
  const auto& stick = map.signals[static_cast<std::size_t>(Signal::kStickRoll)];
  ASSERT_TRUE(stick);
  EXPECT_EQ(stick->column, "rc_roll");
  EXPECT_EQ(stick->offset, -1024);
  EXPECT_EQ(stick->scale, 2);
  EXPECT_EQ(map.signals[static_cast<std::size_t>(Signal::kAttitudeRoll)]->column, "roll");
  EXPECT_EQ(map.extra.at("battery").column, "battery_v");
  EXPECT_EQ(map.time.column, "t_s");
}

struct BadMap {
  const char* name;
  const char* text;
  const char* says;  // file, line, key and error
};

class BadColumnMap : public ::testing::TestWithParam<BadMap> {};

// Catches a reader that ignores unknown keys: a misspelt key would silently become "no such signal".
TEST_P(BadColumnMap, IsRefusedWithItsPlace) {
  const std::string said = complaint_of([] { parse_column_map(GetParam().text, "m.toml"); });
  EXPECT_EQ(said.rfind(GetParam().says, 0), 0U) << said;
}

INSTANTIATE_TEST_SUITE_P(
    Table, BadColumnMap,
    ::testing::Values(BadMap{"NotToml", "time = \n", "m.toml:1: "},
                      BadMap{"UnknownSection", "time = \"t\"\n[signal]\nrate_x = \"p\"\n",
                             "m.toml:2: 'signal': unknown key"},
                      BadMap{"UnknownSignal", "time = \"t\"\n[signals]\nroll = \"p\"\n",
                             "m.toml:3: 'signals.roll': is not a canonical signal"},
                      BadMap{"UnknownEntryKey", "time = \"t\"\n[signals]\nrate_x = { column = \"p\", gain = 2 }\n",
                             "m.toml:3: 'signals.rate_x.gain': unknown key"},
                      BadMap{"OffsetIsText", "time = \"t\"\n[signals]\nrate_x = { column = \"p\", offset = \"2\" }\n",
                             "m.toml:3: 'signals.rate_x.offset': must be a finite number"},
                      BadMap{"ScaleIsNan", "time = \"t\"\n[signals]\nrate_x = { column = \"p\", scale = nan }\n",
                             "m.toml:3: 'signals.rate_x.scale': must be a finite number"},
                      BadMap{"ScaleIsZero", "time = \"t\"\n[signals]\nrate_x = { column = \"p\", scale = 0 }\n",
                             "m.toml:3: 'signals.rate_x.scale': must not be zero"},
                      BadMap{"NoColumn", "time = \"t\"\n[signals]\nrate_x = { offset = 1 }\n",
                             "m.toml:3: 'signals.rate_x': names no column"},
                      BadMap{"ColumnIsANumber", "time = \"t\"\n[signals]\nrate_x = 3\n",
                             "m.toml:3: 'signals.rate_x': must be the name"},
                      BadMap{"NoTime", "[signals]\nrate_x = \"p\"\n", "m.toml: 'time': is missing"},
                      BadMap{"NoSignals", "time = \"t\"\n", "m.toml: 'signals': is missing"}),
    [](const auto& tested) { return tested.param.name; });

}  // namespace
}  // namespace m100::lab::logs
