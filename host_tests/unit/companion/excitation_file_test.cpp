// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/files/excitation_file.h"

#include <gtest/gtest.h>

#include "host_tests/refusal.h"

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
  EXPECT_EQ(made.pieces[0].axis, ctl::ExcitedStick::kRoll);
  EXPECT_EQ(made.pieces[1].axis, ctl::ExcitedStick::kThrottle);
  EXPECT_EQ(made.pieces[1].begin, 2U);
  EXPECT_EQ(made.counts, (std::vector<std::int16_t>{120, -15, 0, 90})) << "without what the law flies";
  EXPECT_EQ(made.limits[2].speed, 1.5);
  EXPECT_TRUE(made.moves(ctl::ExcitedStick::kThrottle));
  EXPECT_FALSE(made.moves(ctl::ExcitedStick::kYaw));
}

// Catches a replay that flies another excitation than the flight did.
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
                      Wrong{"NoPiece", "t_s,piece", "t_s,part", "e.csv:3: needs the columns t_s, piece"},
                      Wrong{"NoTime", "t_s,piece", "t,piece", "e.csv:3: needs the columns t_s, piece"},
                      Wrong{"NoStick", "stick_roll,stick_throttle", "roll,throttle", "e.csv:3: needs the columns"},
                      Wrong{"NoSuchStick", "stick_throttle", "stick_thrust", "e.csv:3: 'stick_thrust': no such stick"},
                      Wrong{"BeyondTheOtherTravel", "120", "-661", "e.csv:4: a stick travels 660 counts"},
                      Wrong{"HalfANumber", "120", "12x", "e.csv:4: column 3 is not a number"},
                      Wrong{"NoCell", "120", "", "e.csv:4: column 3 is not a number"},
                      Wrong{"AShorterPeriod", "0.02,1", "0.0189,1", "e.csv:5: 't_s': samples must be 0.02 s apart"},
                      Wrong{"TimeStandsStill", "0.06,2", "0.04,2", "e.csv:7: 't_s': samples must be 0.02 s apart"},
                      Wrong{"AnotherStickInTheSamePiece", "0.02,1,-15,0", "0.02,1,0,3",
                            "e.csv:5: a piece moves one stick only"},
                      Wrong{"FirstPieceIsTwo", "0,1,120", "0,2,120", "e.csv:4: 'piece': must count up"},
                      Wrong{"HalfAPiece", "0.02,1,-15", "0.02,1.5,-15", "e.csv:5: 'piece': must count up"},
                      Wrong{"DistanceOfNothing", "distance 8", "distance 0", "e.csv:1: expected: limits"},
                      Wrong{"DistanceTooFar", "distance 8", "distance 1001", "e.csv:1: expected: limits"},
                      Wrong{"NoBraking", "braking 2 speed 6", "braking 0 speed 6", "e.csv:1: expected: limits"},
                      Wrong{"SpeedBackwards", "speed 6", "speed -6", "e.csv:1: expected: limits"},
                      Wrong{"NoTilt", "tilt 0.5", "tilt 0", "e.csv:1: expected: limits"},
                      Wrong{"TiltNotSaid", " tilt 0.5", "", "e.csv:1: expected: limits"},
                      Wrong{"WordOfTheDistance", "distance 8", "range 8", "e.csv:1: expected: limits"},
                      Wrong{"WordOfTheBraking", "braking 2 speed 6", "brake 2 speed 6", "e.csv:1: expected: limits"},
                      Wrong{"WordOfTheSpeed", "speed 6", "fast 6", "e.csv:1: expected: limits"},
                      Wrong{"WordOfTheTilt", "tilt 0.5", "lean 0.5", "e.csv:1: expected: limits"},
                      Wrong{"LimitsOfNoStick", "limits throttle", "limits thrust", "e.csv:2: expected: limits"}),
    [](const auto& tested) { return std::string(tested.param.name); });

std::string said_of(const std::string& text) {
  return host_tests::refusal_by<FileError>([&] { (void)parse_excitation(text, "e.csv"); });
}

TEST_P(WrongFile, IsRefusedInOneLine) {
  std::string text = kGood;
  const std::size_t found = text.find(GetParam().from);
  ASSERT_NE(found, std::string::npos);
  text.replace(found, GetParam().from.size(), GetParam().to);
  EXPECT_NE(said_of(text).find(GetParam().said), std::string::npos) << text << said_of(text);
}

constexpr const char* kHead = "# limits roll distance 1000 braking 1000 speed 1000 tilt 0.6\nt_s,piece,stick_roll\n";

/// `pieces` pieces on the roll stick, each `samples` samples long, with a rest of one sample after each.
std::string pieces_text(std::size_t pieces, std::size_t samples) {
  std::string text = kHead;
  std::size_t row = 0;
  const auto put = [&](std::size_t piece) {
    text += std::to_string(row / 50) + "." + std::to_string(100 + row % 50 * 2).substr(1) + "," +
            std::to_string(piece) + ",9\n";
    ++row;
  };
  for (std::size_t piece = 1; piece <= pieces; ++piece) {
    for (std::size_t i = 0; i < samples; ++i) {
      put(piece);
    }
    put(0);
  }
  return text;
}

TEST(ExcitationFile, TakesTheLastGoodNumberOfEachLimit) {
  const ExcitationFile made = parse_excitation(std::string(kHead) + "0,1,660\n0.0205,1,-660\n0.04,1,-15.6\n", "e.csv");
  EXPECT_EQ(made.counts, (std::vector<std::int16_t>{660, -660, -16})) << "counts are whole";
  EXPECT_EQ(made.limits[0].tilt_rad, 0.6);
  EXPECT_EQ(made.limits[0].distance, 1000.0);
  EXPECT_EQ(made.limits[0].braking, 1000.0);
  EXPECT_NEAR(made.length_s(), 0.06, 1e-12);
  const ExcitationFile most = parse_excitation(pieces_text(255, 1), "e.csv");
  EXPECT_EQ(most.pieces.size(), 255U);
  EXPECT_EQ(said_of(pieces_text(256, 1)), "e.csv: more than 255 pieces");
  EXPECT_EQ(parse_excitation(pieces_text(1, 65535), "e.csv").pieces[0].count, 65535U);
  EXPECT_EQ(said_of(pieces_text(1, 65536)), "e.csv: a piece is longer than 20 minutes");
  EXPECT_EQ(said_of(kHead), "e.csv: no piece in it moves a stick; make it with m100-lab excite --out");
}

TEST(ExcitationFile, ReadsWhatASpreadsheetMakesOfIt) {
  const ExcitationFile made = parse_excitation(
      "# made by hand\r\n  \t\r\n# limits yaw distance 3 braking 1 speed 1 tilt 0.3\r\n t_s\t, piece ,stick_yaw , x\r\n"
      "\r\n 0 ,1,\t7 ,\r\n0.02,1, -7,\r\n",
      "e.csv");
  EXPECT_EQ(made.counts, (std::vector<std::int16_t>{7, -7}));
  EXPECT_EQ(made.pieces[0].axis, ctl::ExcitedStick::kYaw);
  EXPECT_TRUE(made.moves(ctl::ExcitedStick::kYaw));
  EXPECT_FALSE(made.moves(ctl::ExcitedStick::kPitch));
  EXPECT_EQ(name(ctl::ExcitedStick::kPitch), "pitch");
}

TEST(ExcitationFile, ANoteHoldsWhatALogCanAndIsReadLineByLine) {
  const ExcitationFile small = parse_excitation(kGood, "e.csv");
  EXPECT_EQ(note_of(small, "e.csv"),
            "limits roll distance 8 braking 2 speed 6 tilt 0.5\n"
            "limits throttle distance 2 braking 2 speed 1.5 tilt 0.34999999999999998\n"
            "roll 120 -15\nthrottle 0 90\n");
  const auto refused = [](const std::string& note) {
    return host_tests::refusal_by<FileError>([&] { (void)excitation_of_note(note); });
  };
  const std::string limits = "limits roll distance 8 braking 2 speed 6 tilt 0.5\n";
  EXPECT_EQ(refused(limits + "roll 1 2\n"), "");
  EXPECT_EQ(refused(limits + "roll 1 2\nrool 1\n"), "the log's excitation:3: 'rool': no such stick");
  EXPECT_EQ(refused(limits + "pitch 1 2\n"),
            "the log's excitation: no limits for pitch in it; m100-lab excite writes them");
  EXPECT_EQ(refused(limits), "the log's excitation: no piece in it moves a stick; make it with m100-lab excite --out");
  EXPECT_EQ(refused("limits roll distance 8\n").find("the log's excitation:1: expected: limits"), 0U);
  // A note holds "roll" and " 9" for each sample; at most 59 000 bytes are allowed, with the line of the limits.
  const ExcitationFile longest = parse_excitation(pieces_text(1, 29400), "e.csv");
  EXPECT_LE(note_of(longest, "e.csv").size(), 59000U);
  EXPECT_THROW((void)note_of(parse_excitation(pieces_text(1, 29500), "e.csv"), "e.csv"), FileError);
}

}  // namespace
}  // namespace m100::companion
