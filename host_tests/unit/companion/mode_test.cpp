// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/files/mode.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

namespace m100::companion {
namespace {

constexpr const char* kFile = "firmware/mpc/generated/vehicle.toml";

std::string read_file(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  return std::string(std::istreambuf_iterator<char>(stream), {});
}

TEST(Mode, HasItsNameBothWays) {
  for (const Mode mode : kModes) {
    EXPECT_EQ(mode_named(name(mode)), mode);
    EXPECT_EQ(name(mode), kModeNames[static_cast<std::size_t>(mode)]);
  }
  EXPECT_FALSE(mode_named("indoors").has_value());
}

// The mode "field" uses the file unchanged, to the last bit, so its gain tables need not be made again.
TEST(Mode, FieldIsTheFileItself) {
  const std::string text = read_file(kFile);
  EXPECT_EQ(text_in_mode(text, kFile, Mode::kField), text);
  EXPECT_EQ(in_mode(parse_vehicle(text, kFile), Mode::kField).digest, parse_vehicle(text, kFile).digest);
}

// Catches a mode that is accepted but changes nothing, and one that changes an identified value.
TEST(Mode, CalmRoomChangesWeightsAndNoisesOnly) {
  const VehicleFile file = load_vehicle(kFile);
  const VehicleFile calm = in_mode(file, Mode::kCalmRoom);
  EXPECT_LT(calm.vehicle.mpc.input, 0.9 * file.vehicle.mpc.input);
  model::Vehicle back = calm.vehicle;
  back.mpc = file.vehicle.mpc;
  back.estimator = file.vehicle.estimator;
  back.design = file.vehicle.design;  // calm_room flies without one
  back.robust = file.vehicle.robust;
  EXPECT_EQ(to_text(back, {}), to_text(file.vehicle, {}));
}

// The mode flies its own section; without it there is one clear line.
TEST(Mode, RobustFliesItsOwnDesign) {
  VehicleFile file = load_vehicle(kFile);
  file.vehicle.robust = {};
  EXPECT_FALSE(has_mode(file, Mode::kRobust));
  EXPECT_THROW(static_cast<void>(in_mode(file, Mode::kRobust)), VehicleFileError);
  file.vehicle.robust.has_mpc = true;
  file.vehicle.robust.mpc.input = 77.0;
  ASSERT_TRUE(has_mode(file, Mode::kRobust));
  EXPECT_EQ(model::controller_model(in_mode(file, Mode::kRobust).vehicle).mpc.input, 77.0);
  EXPECT_NE(model::controller_model(in_mode(file, Mode::kField).vehicle).mpc.input, 77.0);
}

// A table of one mode must not fly in the other mode, nor after any change of the file, even of a comment.
TEST(Mode, EachIsTiedToEveryBitOfTheVehicleFile) {
  RecordProperty("promise", "R10");
  const std::string text = read_file(kFile);
  const auto digest = [](const std::string& of, Mode mode) {
    return parse_vehicle(text_in_mode(of, "vehicle", mode), "vehicle").digest;
  };
  EXPECT_NE(digest(text, Mode::kField), digest(text, Mode::kCalmRoom));
  EXPECT_NE(digest(text, Mode::kCalmRoom), digest(text + "# one more word\n", Mode::kCalmRoom));
  EXPECT_EQ(digest(text, Mode::kCalmRoom), in_mode(parse_vehicle(text, "vehicle"), Mode::kCalmRoom).digest);
}

}  // namespace
}  // namespace m100::companion
