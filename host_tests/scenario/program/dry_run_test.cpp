// SPDX-License-Identifier: BSD-3-Clause
// m100 fly --dry-run does everything of a flight except sending. m100 replay tells whether a log reproduces the flight.
#include "firmware/companion/files/recorded_flight.h"
#include "host_tests/scenario/program/world_fixture.h"

namespace m100::scenario {
namespace {

struct DryRun : WorldTest {
  /// @returns stdout of a run. @param code the expected exit code.
  std::string output(const std::vector<std::string>& arguments, int code) {
    EXPECT_EQ(Process("/bin/sh", {"-c", line_of(arguments) + " > " + said.string()}, errors).wait(), code) << error();
    return text_of(said);
  }
};

// Every option of a flight is accepted, every file is read, the log is written; the autopilot must not get a byte.
TEST_F(DryRun, SendsNothingAtAllAndDoesTheRest) {
  RecordProperty("promise", "R4");
  ASSERT_EQ(fly_in_world("", {"--dry-run", "--hold", "2", "--course", made("course", "step 1 0 0 0 5\n"), "--mode",
                              "robust", "--channel", "movement", "--app-id", "4711"}),
            0)
      << error();
  for (const char* const words : {"dry run: nothing is sent", "switch:    at F", " 0 session failures",
                                  "telemetry comes", "the estimate is healthy"}) {
    EXPECT_NE(text_of(said).find(words), std::string::npos) << words << " is not in\n" << text_of(said);
  }
  const Json flown = reported();
  EXPECT_EQ(flown["bytes_sent"], 0);
  EXPECT_EQ(flown["pose"], true);
  EXPECT_EQ(flown["obtained"], false);
  const Json examiner = summary();
  EXPECT_EQ(examiner["frames"], 0);
  EXPECT_EQ(examiner["bytes_dropped"], 0) << "bytes outside frames were sent";
  const companion::RecordedFlight recorded = companion::read_flight(log.string());
  ASSERT_GT(recorded.ticks.size(), 100U);
  for (const companion::RecordedFlight::Tick& tick : recorded.ticks) {
    ASSERT_TRUE(tick.autopilot_out.empty());
  }
  EXPECT_EQ(recorded.notes.at("m100_mode"), "robust");
  const std::string& flew = recorded.notes.at("m100_vehicle");
  EXPECT_TRUE(flew.starts_with("# robust of the vehicle file with SHA-256 ")) << flew.substr(0, 80);
  EXPECT_EQ(run({"replay", log.string()}), 0) << "the log does not replay: " << error();
}

TEST_F(DryRun, NeedsNothingButAPort) {
  in_real_time([&] {
    const auto autopilot = start_autopilot();
    const std::string words = output({"fly", "--dry-run", "--port", port.string(), "--hold", "1"}, 0);
    EXPECT_NE(words.find("telemetry comes"), std::string::npos) << words;
    EXPECT_EQ(examined(*autopilot)["frames"], 0);
  });
}

TEST_F(DryRun, RefusesWhatTheFlightWouldRefuse) {
  const auto autopilot = start_autopilot();
  const std::string far = made("far", "step 100 0 0 0 5\n");
  EXPECT_EQ(run({"fly", "--dry-run", "--port", port.string(), "--course", far, "--flight", flight_file.string()}), 2);
  EXPECT_NE(error().find("far:1: 'step': x = 100 m"), std::string::npos) << error();
  EXPECT_EQ(run(flight({"--dry-run", "--course", far})), 2);
  EXPECT_NE(error().find("far:1: 'step': x = 100 m"), std::string::npos) << error();
  EXPECT_EQ(run({"fly", "--dry-run", "--port", port.string(), "--gains", table.string()}), 2);
  EXPECT_NE(error().find("--vehicle"), std::string::npos) << error();
  EXPECT_EQ(run({"fly", "--dry-run", "--port", port.string(), "--log", log.string()}), 2);
  EXPECT_NE(error().find("--log"), std::string::npos) << error();
}

// A log with one changed bit in the received bytes must not replay as the same flight, and one with a mission, which is
// no longer flown, not at all.
TEST_F(DryRun, AReplayThatDiffersSaysWhereAndEndsWithOne) {
  RecordProperty("promise", "R6");
  ASSERT_EQ(fly_in_world("", {"--dry-run", "--hold", "2"}), 0) << error();
  std::string bytes = text_of(log);
  // Changes the last record's position: only the last tick may differ.
  const companion::RecordedFlight recorded = companion::read_flight(log.string());
  const auto& last = recorded.ticks.back().record;
  const std::string record(reinterpret_cast<const char*>(&last), sizeof last);
  const std::size_t at = bytes.rfind(record);
  ASSERT_NE(at, std::string::npos);
  const std::size_t offset =
      static_cast<std::size_t>(reinterpret_cast<const char*>(&last.position) - reinterpret_cast<const char*>(&last));
  bytes[at + offset] = static_cast<char>(bytes[at + offset] ^ 1);
  EXPECT_EQ(run({"replay", made("other.ulg", bytes)}), 1);
  EXPECT_NE(error().find("tick " + std::to_string(recorded.ticks.size() - 1) + " (1 in all"), std::string::npos)
      << error();
  EXPECT_EQ(run({"replay", log.string(), "--hash"}), 0) << error();
  EXPECT_EQ(run({"replay", log.string(), "--scalar", "float", "--hash"}), 0) << "another arithmetic must not be judged";
  // A line of text (ULog: size, type, level, time) that former versions wrote when a mission began.
  const std::string line = "6" + std::string(8, '\1') + "mission: active";
  const std::string flown = made("mission.ulg", text_of(log) + static_cast<char>(line.size()) + '\0' + 'L' + line);
  for (const char* const scalar : {"double", "float"}) {
    EXPECT_EQ(run({"replay", flown, "--scalar", scalar}), 2);
    EXPECT_NE(error().find("mission.ulg: the flight flew a MAVLink mission, which this version does not fly"),
              std::string::npos)
        << error();
  }
}

TEST_F(DryRun, HelpShowsTheDefaults) {
  EXPECT_NE(output({"fly", "--help"}, 0).find("}=230400"), std::string::npos);
  EXPECT_NE(output({"handshake", "--help"}, 0).find("[1 - 3600]=30"), std::string::npos);
  EXPECT_NE(output({"probe", "--help"}, 0).find("[0.1 - 60]=2"), std::string::npos);
  EXPECT_NE(output({"replay", "--help"}, 0).find("}=double"), std::string::npos);
}

}  // namespace
}  // namespace m100::scenario
