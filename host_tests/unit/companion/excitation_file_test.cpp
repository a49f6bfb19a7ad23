// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/files/excitation_file.h"

#include <gtest/gtest.h>

namespace m100::companion {
namespace {

constexpr const char* kGood =
    "# limits roll distance 8 braking 2 speed 6 tilt 0.5\n"
    "# limits throttle distance 2 braking 2 speed 1.5 tilt 0.35\n"
    "t_s,piece,stick_roll,stick_throttle,forecast_position_m\n"
    "0,1,120,0,0\n"
    "0.02,1,-15,0,0.1\n"
    "0.04,0,33,0,0.1\n"
    "0.06,2,0,0,0.1\n"
    "0.08,2,0,90,0.1\n";

TEST(ExcitationFile, HoldsThePiecesAndWhatTheyAreAbortedBy) {
  const ExcitationFile made = parse_excitation(kGood, "e.csv");
  ASSERT_EQ(made.pieces.size(), 2U);
  EXPECT_EQ(made.pieces[0].axis, ctl::StickAxis::kRoll);
  EXPECT_EQ(made.pieces[1].axis, ctl::StickAxis::kThrottle);
  EXPECT_EQ(made.pieces[1].begin, 2U);
  EXPECT_EQ(made.counts, (std::vector<std::int16_t>{120, -15, 0, 90})) << "without what the law flies";
  EXPECT_EQ(made.limits[2].speed, 1.5);
  EXPECT_TRUE(made.moves(ctl::StickAxis::kThrottle));
  EXPECT_FALSE(made.moves(ctl::StickAxis::kYaw));
}

// What a replay flies must be what the flight flew.
TEST(ExcitationFile, ComesBackFromItsNote) {
  const ExcitationFile made = parse_excitation(kGood, "e.csv");
  const ExcitationFile back = excitation_of_note(note_of(made, "e.csv"));
  EXPECT_EQ(back.counts, made.counts);
  ASSERT_EQ(back.pieces.size(), made.pieces.size());
  for (std::size_t i = 0; i < made.pieces.size(); ++i) {
    EXPECT_EQ(back.pieces[i].axis, made.pieces[i].axis);
    EXPECT_EQ(back.pieces[i].begin, made.pieces[i].begin);
    EXPECT_EQ(back.pieces[i].count, made.pieces[i].count);
  }
  for (std::size_t axis = 0; axis < ctl::kStickAxes; ++axis) {
    EXPECT_EQ(back.limits[axis].distance, made.limits[axis].distance);
    EXPECT_EQ(back.limits[axis].tilt_rad, made.limits[axis].tilt_rad);
  }
}

struct Wrong {
  const char* name;
  std::string from, to;  ///< of kGood
  const char* said;
};
class WrongFile : public ::testing::TestWithParam<Wrong> {};
INSTANTIATE_TEST_SUITE_P(
    Of, WrongFile,
    ::testing::Values(Wrong{"NoNumber", "120", "a", "e.csv:4: column 3 is not a number"},
                      Wrong{"NotFinite", "120", "nan", "e.csv:4: column 3 is not a number"},
                      Wrong{"TooFewCells", "0.02,1,-15,0,0.1", "0.02,1", "e.csv:5: column 3"},
                      Wrong{"BeyondTheTravel", "120", "661", "e.csv:4: a stick travels 660 counts"},
                      Wrong{"AnotherPeriod", "0.02,1", "0.03,1", "e.csv:5: 't_s': samples must be 0.02 s apart"},
                      Wrong{"TwoSticks", "1,-15,0", "1,-15,3", "e.csv:5: a piece moves one stick only"},
                      Wrong{"PieceLeftOut", "2,0,90", "4,0,90", "e.csv:8: 'piece': must count up"},
                      Wrong{"NoLimits", "# limits roll", "# roll", "e.csv: no limits for roll"},
                      Wrong{"TiltBeyondThePromise", "tilt 0.5", "tilt 0.7", "e.csv:1: expected: limits"},
                      Wrong{"NoPiece", "t_s,piece", "t_s,part", "e.csv:3: needs the columns t_s, piece"}),
    [](const auto& tested) { return std::string(tested.param.name); });

TEST_P(WrongFile, IsRefusedInOneLine) {
  std::string text = kGood;
  const std::size_t found = text.find(GetParam().from);
  ASSERT_NE(found, std::string::npos);
  text.replace(found, GetParam().from.size(), GetParam().to);
  try {
    (void)parse_excitation(text, "e.csv");
    FAIL() << text;
  } catch (const ExcitationFileError& wrong) {
    EXPECT_NE(std::string(wrong.what()).find(GetParam().said), std::string::npos) << wrong.what();
  }
}

}  // namespace
}  // namespace m100::companion
