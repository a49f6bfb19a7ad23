// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/files/vehicle_file.h"

#include <gtest/gtest.h>

#include "firmware/model/default_vehicle.h"
#include "host_tests/refusal.h"

namespace m100::companion {
namespace {

constexpr const char* kGood = R"([axis.roll]
scale_rad_per_count = 9.31e-4
natural_frequency_rad_s = 8.69
damping_ratio = 0.682
dead_zone_counts = 16.1
dead_zone_shape = "jump"
source = "a test"
[axis.pitch]
scale_rad_per_count = 9e-4
time_constant_s = 0.1
)";

TEST(VehicleFile, ReadsWhatTheContractShows) {
  const VehicleFile file = parse_vehicle(kGood, "v.toml");
  EXPECT_EQ(file.vehicle.roll.scale_per_count, 9.31e-4);
  EXPECT_FALSE(file.vehicle.roll.is_first_order());
  EXPECT_EQ(file.vehicle.roll.dead_zone_shape, model::DeadZoneShape::kJump);
  EXPECT_TRUE(file.vehicle.pitch.is_first_order());
  EXPECT_EQ(file.sources.at("axis.roll"), "a test");
  EXPECT_EQ(file.sections, (std::set<std::string>{"axis.roll", "axis.pitch"}));
}

// Catches a key that is written but not read, and a number that loses bits in its text form.
TEST(VehicleFile, WrittenAndReadBackIsTheSameTextAndDigest) {
  const std::map<std::string, std::string> sources{{"axis.roll", "log \"a\", 12 to 38 s"}};
  model::Vehicle vehicle = model::paper_vehicle();
  vehicle.roll.scale_per_count = 1.0 / 1073.0;
  const std::string text = to_text(vehicle, sources);
  const VehicleFile file = parse_vehicle(text, "v.toml");
  EXPECT_EQ(to_text(file.vehicle, file.sources), text);
  EXPECT_EQ(file.digest, as_file(vehicle, sources).digest);
}

// Catches an effect of climb or yaw that identification finds and the file does not keep, and a new key that changes
// the digest of every older file.
TEST(VehicleFile, LateEffectsOfRateAxesAreKeptWhereTheyAreAndUnsaidWhereTheyAreNot) {
  model::Vehicle vehicle = model::paper_vehicle();
  EXPECT_EQ(to_text(vehicle, {}).find("[axis.climb]\nbacklash"), std::string::npos);
  EXPECT_EQ(as_file(vehicle).vehicle.climb.lead_zero_s, 0.0);
  vehicle.climb.lead_zero_s = 0.11;
  vehicle.climb.backlash_counts = 7.0;
  vehicle.yaw_rate.gain_drift_per_minute = -0.2;
  const model::Vehicle read = as_file(vehicle).vehicle;
  EXPECT_EQ(read.climb.lead_zero_s, 0.11);
  EXPECT_EQ(read.climb.backlash_counts, 7.0);
  EXPECT_EQ(read.yaw_rate.gain_drift_per_minute, -0.2);
  EXPECT_EQ(read.yaw_rate.backlash_counts, 0.0);
}

// Catches a writer that writes an axis that was never identified, which the reader then refuses.
TEST(VehicleFile, AnAxisThatIsNotKnownYetIsLeftOut) {
  model::Vehicle vehicle;
  vehicle.roll.time_constant_s = 0.2;
  const VehicleFile file = as_file(vehicle);
  EXPECT_TRUE(file.sections.contains("axis.roll"));
  EXPECT_FALSE(file.sections.contains("axis.pitch"));
}

// Catches a gain in the file that nothing flies, and one that the file loses although it flies.
TEST(VehicleFile, HoldsTheHeightGainsExactlyWhereTheyFly) {
  model::Vehicle vehicle = model::paper_vehicle();
  EXPECT_EQ(to_text(vehicle, {}).find("derivative"), std::string::npos);
  vehicle.altitude.design = false;
  vehicle.altitude.derivative = 0.2;
  const model::AltitudeGains read = as_file(vehicle).vehicle.altitude;
  EXPECT_FALSE(read.design);
  EXPECT_EQ(read.derivative, 0.2);
  EXPECT_EQ(read.integral_per_s2, model::paper::kAltitudeKi);
}

// Files of earlier versions hold the paper's gains, which never flew.
TEST(VehicleFile, AcceptsThePapersGainsBesideADesign) {
  const VehicleFile file = parse_vehicle("[altitude]\nproportional_per_s = 1.963\nclimb_limit_m_s = 1.5\n", "v.toml");
  EXPECT_TRUE(file.vehicle.altitude.design);
  EXPECT_EQ(file.vehicle.altitude.climb_limit_m_s, 1.5);
}

// Promise R10: any single changed bit changes the digest, so the file no longer fits its gain table.
TEST(VehicleFile, EverySingleBitChangesTheDigestOrIsRefused) {
  const std::string text = kGood;
  const core::Sha256Digest digest = parse_vehicle(text, "v.toml").digest;
  for (std::size_t bit = 0; bit < 8 * text.size(); ++bit) {
    std::string damaged = text;
    damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ (1 << (bit % 8)));
    try {
      EXPECT_NE(parse_vehicle(damaged, "v.toml").digest, digest) << "bit " << bit;
    } catch (const FileError&) {
      continue;  // refused, as it should be
    }
  }
  RecordProperty("promise", "R10");
}

struct BadCase {
  const char* name;
  std::string text;
  const char* message;
};

class BadVehicleFile : public ::testing::TestWithParam<BadCase> {};

TEST_P(BadVehicleFile, IsRefusedNamingFileLineAndKey) {
  const auto parse = [] { (void)parse_vehicle(GetParam().text, "v.toml"); };
  EXPECT_EQ(host_tests::refusal_by<FileError>(parse), GetParam().message);
}

INSTANTIATE_TEST_SUITE_P(
    Table, BadVehicleFile,
    ::testing::Values(
        BadCase{"Empty", "", "v.toml: the file is empty"},
        BadCase{"UnknownKey", "[axis.roll]\nscale_rad_per_count = 9e-4\ntime_constant_s = 0.1\nspeed = 3\n",
                "v.toml:4: 'axis.roll.speed': unknown key"},
        BadCase{"UnknownSection", "[wings]\narea = 3\n", "v.toml:1: 'wings': unknown section"},
        BadCase{"UnknownAxis", "[axis.flap]\narea = 3\n", "v.toml:1: 'axis.flap': unknown axis"},
        BadCase{"NegativeTimeConstant", "[axis.roll]\nscale_rad_per_count = 9e-4\ntime_constant_s = -0.1\n",
                "v.toml:3: 'axis.roll.time_constant_s': -0.1 is outside [0.005, 5]"},
        BadCase{"NotANumber", "[axis.roll]\nscale_rad_per_count = \"big\"\n",
                "v.toml:2: 'axis.roll.scale_rad_per_count': must be a number"},
        BadCase{"Nan", "[axis.roll]\nscale_rad_per_count = nan\n",
                "v.toml:2: 'axis.roll.scale_rad_per_count': nan is outside [1e-05, 0.01]"},
        BadCase{"NoNoise", "[estimator]\npose_position_sigma_m = 0.0\n",
                "v.toml:2: 'estimator.pose_position_sigma_m': 0 is outside [1e-05, 1]"},
        BadCase{"BothOrders",
                "[axis.roll]\nscale_rad_per_count = 9e-4\ntime_constant_s = 0.1\nnatural_frequency_rad_s = 9.0\n",
                "v.toml:3: 'axis.roll.time_constant_s': an axis has a time constant or a natural frequency, not both"},
        BadCase{"GainThatNeverFlies", "[altitude]\nderivative = 0.2\n",
                "v.toml:2: 'altitude.derivative': has no effect without design = false"},
        BadCase{"DesignThatIsANumber", "[altitude]\ndesign = 0\n",
                "v.toml:2: 'altitude.design': must be true or false"},
        BadCase{"NoOrder", "[axis.roll]\nscale_rad_per_count = 9e-4\n",
                "v.toml:1: 'axis.roll.time_constant_s': missing: give it, or natural_frequency_rad_s and "
                "damping_ratio"}),
    [](const auto& tested) { return tested.param.name; });

constexpr const char* kAxes =
    "[axis.roll]\nscale_rad_per_count = 0.0009\nnatural_frequency_rad_s = 7.0\nnatural_frequency_rad_s_low = 6.5\n"
    "natural_frequency_rad_s_high = 7.5\ndamping_ratio = 0.7\n"
    "[axis.pitch]\nscale_rad_per_count = 0.0009\nnatural_frequency_rad_s = 6.0\ndamping_ratio = 0.7\n";

// Everything that identification and tuning write must survive a program that reads and writes the file.
TEST(VehicleFile, KeepsDesignIntervalsAndRivals) {
  const std::string text = std::string(kAxes) +
                           "[mpc]\nvelocity = 11.0\n[design.mpc]\ninput = 16.0\n[design.robust.estimator]\n"
                           "rate_sigma_rad_s = 0.1\n[[rival]]\naxis = \"roll\"\nprobability = 0.3\n"
                           "scale_rad_per_count = 0.00093\nnatural_frequency_rad_s = 9.1\ndamping_ratio = 0.69\n"
                           "damping_ratio_low = 0.6\ndamping_ratio_high = 0.8\n";
  const VehicleFile file = parse_vehicle(text, "v.toml");
  EXPECT_EQ(file.vehicle.design.mpc.input, 16.0);
  EXPECT_EQ(file.vehicle.design.mpc.velocity, 11.0) << "what [design] does not say is the vehicle's own";
  EXPECT_FALSE(file.vehicle.design.has_estimator);
  EXPECT_EQ(model::controller_model(file.vehicle).mpc.input, 16.0);
  EXPECT_EQ(model::controller_model(file.vehicle).estimator.rate_sigma_rad_s, file.vehicle.estimator.rate_sigma_rad_s);
  EXPECT_EQ(file.intervals.at("axis.roll").at("natural_frequency_rad_s").high, 7.5);
  ASSERT_EQ(file.rivals.size(), 1U);
  EXPECT_EQ(file.rivals[0].numbers.natural_frequency_rad_s, 9.1);
  EXPECT_EQ(file.rivals[0].intervals.at("damping_ratio").low, 0.6);
  const std::string written = to_text(file);
  EXPECT_EQ(to_text(parse_vehicle(written, "again")), written);
  EXPECT_EQ(parse_vehicle(written, "again").rivals[0].probability, 0.3);
}

TEST(VehicleFile, RefusesAHalfIntervalAndAStrangeRival) {
  const auto refused = [](const std::string& more, const std::string& why) {
    const std::string said = host_tests::refusal_by<FileError>([&] { (void)parse_vehicle(kAxes + more, "v.toml"); });
    EXPECT_NE(said.find(why), std::string::npos) << more << said;
  };
  refused("damping_ratio_low = 0.6\n", "'axis.pitch.damping_ratio_high': missing");
  refused("damping_ratio_low = 0.8\ndamping_ratio_high = 0.6\n", "must not be above");
  refused("[[rival]]\naxis = \"yaw\"\nscale_rad_per_count = 0.001\n", "'rival.axis': must be");
  refused("[design.mpc]\nimput = 3.0\n", "'design.mpc.imput': unknown key");
  refused("[design.yaw]\nx = 3.0\n", "'design.yaw': unknown section");
}

}  // namespace
}  // namespace m100::companion
