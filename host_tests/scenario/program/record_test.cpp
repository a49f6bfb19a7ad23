// SPDX-License-Identifier: BSD-3-Clause
// m100 record with m100-lab autopilot, and with a plain pseudo-terminal: it must send nothing, and its log must have
// everything that m100-lab identify needs.
#include <fcntl.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <termios.h>

#include <cmath>

#include "hal/linux/descriptor.h"
#include "host_tests/scenario/program/world_fixture.h"
#include "host_tests/sim/world/plant.h"
#include "protocol/dji/frame_encoder.h"
#include "protocol/dji/session.h"
#include "protocol/dji/telemetry.h"
#include "protocol/mavlink/frame.h"
#include "protocol/mavlink/pose_messages.h"

namespace m100::scenario {
namespace {

/// The far end of a line, used by the test.
class FarEnd {
 public:
  FarEnd() : descriptor_(posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK)) {
    EXPECT_TRUE(grantpt(descriptor_.number) == 0 && unlockpt(descriptor_.number) == 0);
    near_ =
        hal::Descriptor(open(name().c_str(), O_RDWR | O_NOCTTY));  // sets raw mode before anyone else opens it: no echo
    termios raw{};
    tcgetattr(near_.number, &raw);
    cfmakeraw(&raw);
    tcsetattr(near_.number, TCSANOW, &raw);
  }
  std::string name() const { return ptsname(descriptor_.number); }
  /// Sends the bytes; drops them where the program has not yet read what came before, as it may on a busy machine: the
  /// line would in the end take only a part of a packet.
  void say(std::span<const std::byte> bytes) const {
    int unread = 0;
    ASSERT_EQ(ioctl(near_.number, FIONREAD, &unread), 0);
    if (unread < 2048) {
      EXPECT_EQ(write(descriptor_.number, bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
    }
  }
  std::size_t heard() const {
    std::array<std::byte, 256> bytes;
    const ssize_t count = read(descriptor_.number, bytes.data(), bytes.size());
    return static_cast<std::size_t>(std::max<ssize_t>(count, 0));
  }

 private:
  hal::Descriptor descriptor_, near_;
};

void tell_telemetry(const FarEnd& line, std::uint16_t number, bool with_sticks) {
  protocol::Telemetry telemetry;
  telemetry.items =
      with_sticks ? protocol::kAllTelemetryItems : static_cast<std::uint16_t>(protocol::TelemetryItem::kAttitude);
  telemetry.time.ticks = 8U * number;  // every 20 ms
  std::array<std::byte, 256> space;
  const core::Expected<std::span<const std::byte>> frame = protocol::encode_frame(
      {.session = protocol::kUnansweredSession, .is_ack = false, .encrypted = false, .sequence = number},
      &protocol::ids::kTelemetry, encode(telemetry), space);
  ASSERT_TRUE(frame);
  line.say(*frame);
}

/// One pose from each of two senders: components 197 and 198 of system 1.
void send_poses(const FarEnd& line, std::uint16_t number) {
  for (const std::uint8_t component : {std::uint8_t{197}, std::uint8_t{198}}) {
    const mavlink::AttPosMocap pose{
        .time_usec = std::uint64_t{20000} * (number + 1U), .q = {1.F, 0.F, 0.F, 0.F}, .z = -1.F};
    const mavlink::Frame frame = mavlink::encode(pose, {1, component}, static_cast<std::uint8_t>(number));
    line.say(frame.bytes());
  }
}

class Record : public WorldTest {
 protected:
  /// Feeds telemetry until the program ends. @returns its exit code.
  /// @param enough size of the log at which the test interrupts the program: what a log of this size holds does not
  ///   depend on the machine's load, as what came within a time does.
  int record(const Words& more, const FarEnd& line, const FarEnd& pose_line, bool with_sticks = true,
             std::uintmax_t enough = 32768) {
    const Words words{"record", "--port", line.name(), "--log", log.string(), "--json", result.string()};
    Process program(M100_PROGRAM, with(words, more), errors);
    int code = -1;
    for (std::uint16_t number = 0; program.id() > 0; ++number) {
      tell_telemetry(line, number, with_sticks);
      if (sends_poses_) {
        send_poses(pose_line, number);
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      heard_ += line.heard() + pose_line.heard();
      code = program.wait(std::chrono::seconds(0));
      if (program.id() > 0 && fs::exists(log) && fs::file_size(log) >= enough) {
        program.interrupt();
      }
    }
    return code;
  }
  std::size_t heard_ = 0;
  bool sends_poses_ = false;
};

// Catches a program that requests rates, activates, or answers the pose source. The test waits for the size of the log,
// not for a time: its header and a hundred packages of some 300 bytes. unit.recorder tests in simulated time that the
// rates are those of the autopilot's clock.
TEST_F(Record, SendsNotOneByte) {
  const FarEnd line, pose_line;
  EXPECT_EQ(record({}, line, pose_line), 0) << error();
  EXPECT_EQ(heard_ + line.heard() + pose_line.heard(), 0U);
  const Json report = reported();
  EXPECT_EQ(report["recorded"], true);
  EXPECT_GT(report["streams"]["rc"]["samples"], 10);
  EXPECT_EQ(report["streams"]["rc"]["samples"], report["packages"]);
}

TEST_F(Record, SaysWhatIsMissingForIdentification) {
  const FarEnd line, pose_line;
  EXPECT_EQ(record({}, line, pose_line, false, 12288), 1);
  EXPECT_NE(error().find("the telemetry holds no sticks; switch the item on"), std::string::npos) << error();
  fs::remove(log);
  EXPECT_EQ(record({"--pose-port", pose_line.name()}, line, pose_line), 1);
  EXPECT_NE(error().find("no pose came"), std::string::npos) << error();
  EXPECT_EQ(heard_, 0U);
  fs::remove(log);
  EXPECT_EQ(run({"record", "--port", pose_line.name(), "--log", log.string(), "--hold", "0.3"}), 1);
  EXPECT_NE(error().find("no telemetry came"), std::string::npos) << error();
}

TEST_F(Record, NamesTwoSendersOfPosesAndRecordsTheChosenOne) {
  const FarEnd line, pose_line;
  sends_poses_ = true;
  EXPECT_EQ(record({"--pose-port", pose_line.name()}, line, pose_line), 1);
  EXPECT_NE(error().find("system 1 component 197"), std::string::npos) << error();
  EXPECT_NE(error().find("system 1 component 198"), std::string::npos) << error();
  EXPECT_NE(error().find("choose with --pose-from"), std::string::npos) << error();
  fs::remove(log);
  EXPECT_EQ(record({"--pose-port", pose_line.name(), "--pose-from", "1:198"}, line, pose_line), 0) << error();
  const Json report = reported();
  EXPECT_GT(report["pose"]["used"], 1);
  EXPECT_EQ(report["pose"]["senders"].size(), 2U);
}

TEST_F(Record, RefusesWhatItCannotDo) {
  const FarEnd line;
  made("flight.ulg", "a flight");
  EXPECT_EQ(run({"record", "--port", line.name(), "--log", log.string(), "--hold", "1"}), 2);
  EXPECT_NE(error().find("a log is not overwritten"), std::string::npos) << error();
  EXPECT_EQ(run({"record", "--port", "/dev/null/none", "--log", (folder / "b.ulg").string(), "--hold", "1"}), 2);
  EXPECT_NE(error().find("no such serial port"), std::string::npos) << error();
  EXPECT_EQ(run({"record", "--port", line.name()}), 2);
  EXPECT_NE(error().find("--log"), std::string::npos) << error();
}

TEST_F(Record, AFullDiskEndsTheRecordingWithOneLine) {
  const FarEnd line, pose_line;
  const std::string command =
      "ulimit -f 20; exec " + std::string(M100_PROGRAM) + " record --port " + line.name() + " --log " + log.string();
  Process program("/bin/sh", {"-c", command}, errors);
  int code = -1;
  for (std::uint16_t number = 0; program.id() > 0; ++number) {
    tell_telemetry(line, number, true);
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    code = program.wait(std::chrono::seconds(0));
  }
  EXPECT_EQ(code, 1);
  EXPECT_NE(error().find(log.string() + ": the file size limit is reached (ulimit -f); the recording ends here"),
            std::string::npos)
      << error();
  EXPECT_EQ(run_lab({"logs", log.string()}), 0) << "the part that was written cannot be read: " << error();
}

// The paper's method: the pilot moves one stick after the other by hand, and the program sends nothing.
TEST_F(Record, AHandFlownLogIsIdentifiedWithTheShippedMap) {
  const fs::path script = folder / "pilot.txt";
  std::ofstream words(script);
  double at_s = 4.0;
  for (int round = 0; round < 3; ++round) {
    for (const char* const stick : {"roll", "pitch"}) {
      const double side = round % 2 == 0 ? 1.0 : -1.0;
      words << at_s << " 3211 " << stick << " " << 150.0 * side << " 0.3\n"
            << at_s + 6.0 << " doublet " << stick << " " << -60.0 * side << " 0.6\n"
            << at_s + 11.0 << " chirp " << stick << " " << 120.0 * side << " 0.5 2.5 6\n";
      at_s += 20.0;
    }
  }
  words.close();
  const auto autopilot = start_world({"--rc-mode", "P", "--script", script.string()});
  ASSERT_EQ(run({"record", "--port", world, "--pose-port", world + ".pose", "--log", log.string(), "--hold",
                 std::to_string(at_s), "--json", result.string()}),
            0)
      << error();
  autopilot->interrupt();
  const Json report = reported();
  EXPECT_EQ(report["streams"]["rc"]["gaps"], 0);
  EXPECT_GE(report["sticks"]["roll"]["most_counts"], 150.0);

  const sim::Plant plant = sim::measured_plant();
  for (const auto& [axis, truth] : {std::pair{"roll", plant.roll}, std::pair{"pitch", plant.pitch}}) {
    const fs::path answer = folder / (std::string(axis) + ".json");
    ASSERT_EQ(run_lab({"identify", "--log", log.string(), "--columns",
                       std::string(M100_MAPS) + "/m100_recording_with_pose.toml", "--axis", axis, "--declare",
                       "second_order,transport_delay,dead_zone", "--split", "alternate:6", "--json", answer.string()}),
              0)
        << error();
    const Json found = Json::parse(text_of(answer))["final"]["parameters"];
    EXPECT_NEAR(found["natural_frequency_rad_s"].get<double>(), truth.natural_frequency_rad_s,
                0.1 * truth.natural_frequency_rad_s);
    EXPECT_NEAR(found["damping_ratio"].get<double>(), truth.damping_ratio, 0.1);
    EXPECT_NEAR(found["width_counts"].get<double>(), truth.dead_zone_counts, 4.0);
  }
}

}  // namespace
}  // namespace m100::scenario
