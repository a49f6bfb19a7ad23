// SPDX-License-Identifier: BSD-3-Clause
// Which options of the pose port go together: unsigned frames come over a network from this board alone.
#include "firmware/companion/files/pose_options.h"

#include <gtest/gtest.h>

#include "firmware/companion/command_line.h"

namespace m100::companion {
namespace {

constexpr const char* kHere = "udp:127.0.0.1:14560";

struct WrongPoseOptions {
  const char* name;
  PoseOptions options;
  const char* because;
};

struct PoseOptionsWrong : ::testing::TestWithParam<WrongPoseOptions> {};

TEST_P(PoseOptionsWrong, IsRefusedByOneSentence) {
  const std::string conflict = conflict_of(GetParam().options);
  EXPECT_NE(conflict.find(GetParam().because), std::string::npos) << conflict;
  EXPECT_EQ(conflict.find('\n'), std::string::npos);
}

PoseOptions options_of(const char* port, const char* from, const char* set_points, const char* key) {
  PoseOptions options;
  options.port = port;
  options.from = from;
  options.set_points_from = set_points;
  options.key_file = key;
  return options;
}

INSTANTIATE_TEST_SUITE_P(
    Each, PoseOptionsWrong,
    ::testing::Values(
        WrongPoseOptions{"NetworkWithoutKey", options_of("udp:14560", "1:240", "", ""),
                         "poses over a network must be signed"},
        WrongPoseOptions{"OtherAddress", options_of("udp:127.0.0.2:14560", "1:240", "", ""),
                         "a UDP port is written udp:PORT"},
        WrongPoseOptions{"AllAddresses", options_of("udp:0.0.0.0:14560", "1:240", "", ""),
                         "a UDP port is written udp:PORT"},
        WrongPoseOptions{"HostName", options_of("udp:localhost:14560", "1:240", "", ""),
                         "a UDP port is written udp:PORT"},
        WrongPoseOptions{"NoPort", options_of("udp:127.0.0.1:0", "1:240", "", ""), "a UDP port is written udp:PORT"},
        WrongPoseOptions{"AnySender", options_of(kHere, "", "", ""), "unsigned poses need --pose-from"},
        WrongPoseOptions{"BadSender", options_of(kHere, "mavros", "", ""), "--pose-from: must be a sender's system"},
        WrongPoseOptions{"SetPointsOfASystem", options_of(kHere, "1:240", "1", ""), "needs system and component"},
        WrongPoseOptions{"SetPointsBesideAKey", options_of(kHere, "1:240", "1:240", "k"),
                         "every holder of the key may send them"},
        WrongPoseOptions{"SetPointsOnASerialPort", options_of("/dev/ttyUSB1", "1:240", "1:240", ""),
                         "127.0.0.1:PORT only"},
        WrongPoseOptions{"SetPointsOverANetwork", options_of("udp:14560", "", "1:240", "k"), "every holder of the key"},
        WrongPoseOptions{"SetPointsWithoutAPort", options_of("", "", "1:240", ""), "127.0.0.1:PORT only"},
        WrongPoseOptions{"KeyWithoutAPort", options_of("", "", "", "k"), "needs --pose-port"}),
    [](const auto& test) { return std::string(test.param.name); });

// What one command prints, the next accepts and means the same.
TEST(PoseOptionsRight, AreAcceptedAndWrittenAsWordsThatMeanTheSame) {
  for (const PoseOptions& options :
       {options_of(kHere, "1", "", ""), options_of(kHere, "1:240", "1:240", ""), options_of(kHere, "", "", "k"),
        options_of("udp:14560", "", "", "k"), options_of("/dev/ttyUSB1", "", "", ""),
        options_of("/dev/ttyUSB1", "2:1", "", "k")}) {
    EXPECT_EQ(conflict_of(options), "");
    CommandLine app("test");
    PoseOptions read;
    add_pose_options(app, read);
    app.parse(words_of(options));
    EXPECT_EQ(words_of(read), words_of(options));
  }
  EXPECT_FALSE(unsigned_sender(options_of(kHere, "", "", "k"))) << "signed: everybody with the key";
  EXPECT_EQ(unsigned_sender(options_of(kHere, "1", "", ""))->system, 0) << "nobody";
  EXPECT_EQ(unsigned_sender(options_of(kHere, "1", "7:9", ""))->component, 9);
}

}  // namespace
}  // namespace m100::companion
