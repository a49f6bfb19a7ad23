// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/files/mode.h"

#include <gtest/gtest.h>

#include "firmware/companion/files/text/text_file.h"

namespace m100::companion {
namespace {

constexpr const char* kFile = "firmware/mpc/generated/vehicle.toml";

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

// A flight file or a command of a user who flew the former mode must still fly, and tell the user what flies.
TEST(Mode, TheFormerModeIsFlownWithFieldAndSaid) {
  testing::internal::CaptureStdout();
  EXPECT_EQ(present_mode_word("calm_room"), name(Mode::kField));
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "calm_room is gone: flown with field\n");
  testing::internal::CaptureStdout();
  EXPECT_EQ(present_mode_word("robust"), "robust");
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
}

// The mode flies its own section; without it there is one clear line.
TEST(Mode, RobustFliesItsOwnDesign) {
  VehicleFile file = load_vehicle(kFile);
  file.vehicle.robust = {};
  EXPECT_FALSE(has_mode(file, Mode::kRobust));
  EXPECT_THROW(static_cast<void>(in_mode(file, Mode::kRobust)), FileError);
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
  EXPECT_NE(digest(text, Mode::kField), digest(text, Mode::kRobust));
  EXPECT_NE(digest(text, Mode::kRobust), digest(text + "# one more word\n", Mode::kRobust));
  EXPECT_EQ(digest(text, Mode::kRobust), in_mode(parse_vehicle(text, "vehicle"), Mode::kRobust).digest);
}

}  // namespace
}  // namespace m100::companion
