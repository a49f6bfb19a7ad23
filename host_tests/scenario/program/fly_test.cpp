// SPDX-License-Identifier: BSD-3-Clause
// m100 fly with m100-lab autopilot, as two programs: the files that it writes, and how it ends.
#include <fcntl.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>

#include "firmware/companion/files/recorded_flight.h"
#include "hal/linux/descriptor.h"
#include "host_tests/scenario/program/program_fixture.h"

namespace m100::scenario {
namespace {

constexpr const char* kKey = "00112233445566778899aabbccddeeff0123456789abcdef0123456789abcdef";

struct Flown {
  const char* name;
  std::vector<std::string> autopilot;
  std::vector<std::string> options;
};
class FlyAndReplay : public ProgramTest, public ::testing::WithParamInterface<Flown> {};
INSTANTIATE_TEST_SUITE_P(
    Program, FlyAndReplay,
    ::testing::Values(Flown{"VirtualRc", {}, {"--app-id", "4711"}},
                      Flown{"VirtualRcAtTenHertz", {}, {"--rate", "10", "--pose-baud", "921600"}},
                      Flown{"MovementEncryptedOnABadLine", {"--loss", "0.01"}, {"--channel", "movement"}}),
    [](const auto& tested) { return tested.param.name; });

TEST_P(FlyAndReplay, TheLogGivesEveryByteOfTheFlightAgain) {
  RecordProperty("promise", "R6");
  in_real_time([&] {
    const Words keys = GetParam().autopilot.empty() ? Words{} : Words{"--key-file", key_file(kKey).string()};
    const auto autopilot = start_autopilot(with(GetParam().autopilot, keys));
    const Words options{"--once", "--hold", "3", "--log", log.string()};
    (void)run(flight(with(with(options, GetParam().options),
                          keys)));  // a busy machine may end the flight early; the log must replay nevertheless
    (void)examined(*autopilot);

    const companion::RecordedFlight flown = companion::read_flight(log.string());
    ASSERT_GT(flown.ticks.size(), 200U);
    ASSERT_EQ(flown.ticks.back().record.dropped_messages, 0U);
    const std::string file = text_of(log);  // one line per second about the link
    std::size_t lines = 0;
    for (std::size_t at = file.find("link_health {"); at != std::string::npos;
         at = file.find("link_health {", at + 1)) {
      const Json health = Json::parse(file.substr(at + 12, file.find('}', at) - at - 11));
      for (const char* const key : {"telemetry_rate_hz", "telemetry_age_s", "jitter_histogram", "crc16_errors",
                                    "crc32_errors", "resyncs", "bytes_dropped", "session_failures", "receive_share"}) {
        EXPECT_TRUE(health.contains(key)) << key;
      }
      ++lines;
    }
    EXPECT_GE(lines, flown.ticks.size() / 150);
    const fs::path said = folder / "said.txt";
    const std::string replay = std::string(M100_PROGRAM) + " replay " + log.string() +
                               (keys.empty() ? "" : " --key-file " + keys[1]) + " > " + said.string();
    ASSERT_EQ(Process("/bin/sh", {"-c", replay}).wait(), 0);
    EXPECT_NE(text_of(said).find(", 0 differ from the log"), std::string::npos) << text_of(said);
    if (!keys.empty()) {
      EXPECT_EQ(run({"replay", log.string()}), 2);
      EXPECT_NE(error().find("--key-file"), std::string::npos) << error();
    }
  });
}

class EndedBySignal : public ProgramTest, public ::testing::WithParamInterface<int> {};
INSTANTIATE_TEST_SUITE_P(Program, EndedBySignal, ::testing::Values(SIGINT, SIGTERM, SIGHUP, SIGQUIT),
                         [](const auto& tested) { return std::string(sigabbrev_np(tested.param)); });

TEST_P(EndedBySignal, GivesControlBackInFlight) {
  RecordProperty("promise", "R12");
  in_real_time([&] {
    const auto autopilot = start_autopilot();
    Process program(M100_PROGRAM, flight({"--hold", "60"}), errors);
    ASSERT_TRUE(wait_for_control());
    std::this_thread::sleep_for(std::chrono::seconds(1));
    program.send(GetParam());
    EXPECT_EQ(program.wait(), 0);
    EXPECT_EQ(examined(*autopilot)["client_in_control"], false);
  });
}

// The answer that grants control may already be on its way when the operator interrupts the program.
TEST_F(ProgramTest, AnInterruptWhileControlIsAskedForLeavesNothingHeld) {
  in_real_time([&] {
    const auto autopilot = start_autopilot();
    for (const int wait_ms : {0, 15, 30, 45}) {
      const std::string first_answer = "\"control\",\"value\":3";
      const std::size_t before = noted(first_answer);
      Process program(M100_PROGRAM, flight({"--hold", "60", "--json", result.string()}), errors);
      ASSERT_TRUE(wait_for(first_answer, before));
      std::this_thread::sleep_for(
          std::chrono::milliseconds(1950 + wait_ms));  // the second request is 2 s after the first
      program.interrupt();
      const int code = program.wait();
      const bool flew = reported()["obtained"].get<bool>();
      EXPECT_EQ(code, flew ? 0 : 1) << "exit code 0 only if it flew";
    }
    EXPECT_EQ(examined(*autopilot)["client_in_control"], false);
  });
}

// `m100 fly | head -1`: the reader closes the pipe, and the flight must continue to its end.
TEST_F(ProgramTest, AReaderThatLeavesDoesNotEndTheFlight) {
  in_real_time([&] {
    const auto autopilot = start_autopilot();
    const std::string line = line_of(flight({"--hold", "3", "--json", result.string()}));
    ASSERT_EQ(Process("/bin/sh", {"-c", line + " | head -1 >/dev/null"}).wait(), 0);
    ASSERT_TRUE(wait_until([&] { return reported().is_object(); }));
    EXPECT_EQ(reported()["released"], true);
    EXPECT_EQ(examined(*autopilot)["client_in_control"], false);
  });
}

// With closed standard streams, the port may get their descriptors: output must not go to the autopilot, and its
// telemetry must not be read as the operator's keys.
TEST_F(ProgramTest, WithItsStandardStreamsClosedItFliesAllTheSame) {
  in_real_time([&] {
    const auto autopilot = start_autopilot();
    const std::string line = line_of(flight({"--hold", "3", "--json", result.string()}));
    ASSERT_EQ(Process("/bin/sh", {"-c", "exec " + line + " <&- >&- 2>&-"}).wait(), 0);
    EXPECT_EQ(reported()["released"], true);
    const Json examiner = examined(*autopilot);
    EXPECT_GT(examiner["virtual_rc_taken"], 40) << "of 75 in three seconds";
    EXPECT_EQ(examiner["bytes_dropped"], 0) << "bytes outside frames were sent";
  });
}

/// A pseudo-terminal of the test: output of programs waits until it is read at the other end.
class Terminal {
 public:
  Terminal() : other_end_(posix_openpt(O_RDWR | O_NOCTTY)) {
    EXPECT_TRUE(grantpt(other_end_.number) == 0 && unlockpt(other_end_.number) == 0);
    screen_ = hal::Descriptor(open(ptsname(other_end_.number), O_RDWR | O_NOCTTY));
    EXPECT_GE(screen(), 0);
  }
  int screen() const { return screen_.number; }
  /// Writes this many bytes to the screen, or as many as it takes. @returns their number.
  std::size_t fill(std::size_t bytes) const {
    const hal::Descriptor own(open(ptsname(other_end_.number), O_WRONLY | O_NOCTTY | O_NONBLOCK));
    const std::string text(64, '.');
    std::size_t written = 0;
    for (ssize_t count = 1; count > 0 && written < bytes;
         written += static_cast<std::size_t>(std::max<ssize_t>(count, 0))) {
      count = ::write(own.number, text.data(), std::min(text.size(), bytes - written));
    }
    return written;
  }

 private:
  hal::Descriptor other_end_, screen_;
};

// Ctrl-S in the terminal stops its output, but must not stop the tick.
TEST_F(ProgramTest, AStoppedTerminalDoesNotStopTheFlight) {
  RecordProperty("promise", "R9");
  in_real_time([&] {
    const auto autopilot = start_autopilot();
    const Terminal terminal;
    Process program(M100_PROGRAM, flight({"--hold", "3", "--json", result.string()}), errors, terminal.screen());
    ASSERT_TRUE(wait_for_control());
    ASSERT_EQ(tcflow(terminal.screen(), TCOOFF), 0);
    EXPECT_TRUE(wait_for("\"released\"")) << "control did not go back";
    EXPECT_EQ(tcflow(terminal.screen(), TCOON), 0);
    EXPECT_EQ(program.wait(), 0);
    EXPECT_EQ(examined(*autopilot)["client_in_control"], false);
  });
}

constexpr std::size_t kFewLines = 1500;  ///< bytes: part of the output before control and in three seconds of it

// A network session that broke off: nobody reads the terminal any more, and only a part of a line fits into it.
TEST_F(ProgramTest, ATerminalThatNobodyReadsDoesNotStopTheFlight) {
  RecordProperty("promise", "R9");
  in_real_time([&] {
    const auto autopilot = start_autopilot();
    const Terminal terminal;
    const std::size_t all = Terminal().fill(1'000'000);
    ASSERT_GT(all, kFewLines);
    terminal.fill(all - kFewLines);
    Process program(M100_PROGRAM, flight({"--hold", "3", "--json", result.string(), "--status", "always"}), errors,
                    terminal.screen());
    EXPECT_EQ(program.wait(), 0);
    const Json result_json = reported();
    EXPECT_EQ(result_json["released"], true);
    EXPECT_EQ(result_json["last_reason"], "released") << result_json;
    EXPECT_EQ(examined(*autopilot)["client_in_control"], false);
  });
}

TEST_F(ProgramTest, AFullDiskEndsTheLogAndNotTheFlight) {
  RecordProperty("promise", "R12");
  in_real_time([&] {
    const auto autopilot = start_autopilot();
    const std::string line = line_of(flight({"--hold", "4", "--log", log.string()}));
    EXPECT_EQ(Process("/bin/sh", {"-c", "ulimit -f 400; exec " + line}, errors).wait(), 0) << error();
    EXPECT_NE(error().find(log.string() + ": the file size limit is reached"), std::string::npos) << error();
    const Json examiner = examined(*autopilot);
    EXPECT_EQ(examiner["client_in_control"], false);
    EXPECT_GT(examiner["virtual_rc_taken"], 60);
    EXPECT_GT(companion::read_flight(log.string()).ticks.size(), 50U) << "the part that was written cannot be read";
  });
}

// A full disk must not change the exit code, which says whether the flight was flown.
TEST_F(ProgramTest, AResultThatCannotBeWrittenAfterwardsIsSaidAndChangesNoExitCode) {
  in_real_time([&] {
    const auto autopilot = start_autopilot();
    EXPECT_EQ(run(flight({"--hold", "1", "--json", "/dev/full"})), 0) << error();
    EXPECT_NE(error().find("/dev/full: cannot be written: the disk is full"), std::string::npos) << error();
    EXPECT_EQ(examined(*autopilot)["client_in_control"], false);
  });
}

TEST_F(ProgramTest, AnAdapterPulledOutInFlightEndsTheFlightWithOne) {
  RecordProperty("promise", "R12");
  in_real_time([&] {
    auto autopilot = start_autopilot();
    Process program(M100_PROGRAM, flight({"--once", "--hold", "60", "--json", result.string()}), errors);
    ASSERT_TRUE(wait_for_control());
    std::this_thread::sleep_for(std::chrono::seconds(1));
    fs::remove(port);  // as udev does; another terminal may soon have the same number
    fs::remove(pose);
    autopilot->send(SIGKILL);
    autopilot.reset();  // closes its pseudo-terminals
    EXPECT_EQ(program.wait(), 1);
    EXPECT_EQ(reported()["last_reason"], "link_silent");
  });
}

TEST_F(ProgramTest, TheSecondProgramOnAPortIsRefused) {
  in_real_time([&] {
    const auto autopilot = start_autopilot();
    Process first(M100_PROGRAM, flight({"--hold", "4"}));
    ASSERT_TRUE(wait_for_control());
    EXPECT_EQ(run(flight()), 2);
    EXPECT_NE(error().find("another program"), std::string::npos) << error();
    EXPECT_EQ(first.wait(), 0) << "the first program was disturbed";
    EXPECT_EQ(examined(*autopilot)["client_in_control"], false);
  });
}

// Catches an emulated autopilot that can only be killed before a client takes part: simulated time then stands still.
TEST_F(ProgramTest, AnAutopilotInSimulatedTimeEndsByASignalThoughNobodyCame) {
  for (const int signal : {SIGTERM, SIGINT}) {
    const fs::path world = folder / ("world" + std::to_string(signal));
    Process autopilot(M100_LAB_PROGRAM, {"autopilot", "--sim", world.string(), "--events", events.string()});
    EXPECT_TRUE(wait_until([&] { return fs::exists(world) && fs::exists(events); }));
    autopilot.send(signal);
    EXPECT_EQ(autopilot.wait(), 0) << "signal " << signal;
    EXPECT_NE(text_of(events).find("client_in_control"), std::string::npos) << "the summary is missing";
    EXPECT_FALSE(fs::exists(world)) << "its sockets are not removed";
    fs::remove(events);
  }
}

}  // namespace
}  // namespace m100::scenario
