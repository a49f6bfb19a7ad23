// SPDX-License-Identifier: BSD-3-Clause
// The flying program, a real process on a pseudo-terminal, dies or hangs in flight: the second process must give
// control back. Judged by the autopilot's events.
#include <sys/prctl.h>

#include <chrono>
#include <optional>
#include <thread>

#include "host_tests/scenario/program/program_fixture.h"

namespace m100::scenario {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr const char* kKey = "00112233445566778899aabbccddeeff0123456789abcdef0123456789abcdef";
constexpr double kGivenBack_s = 1.5;  ///< promise R15

struct Case {
  const char* name;
  const char* channel;
  int signal;
  bool encrypted;
};

struct DeathInFlight : ProgramTest, ::testing::WithParamInterface<Case> {
  Words key() const { return GetParam().encrypted ? Words{"--key-file", key_file(kKey).string()} : Words{}; }
  /// Time from `since` until the autopilot's events show the release; empty if it never happens.
  std::optional<double> seconds_until_released(Clock::time_point since) const {
    if (!wait_for("\"released\"")) {
      return std::nullopt;
    }
    return std::chrono::duration<double>(Clock::now() - since).count();
  }
};

INSTANTIATE_TEST_SUITE_P(Program, DeathInFlight,
                         ::testing::Values(Case{"KilledOnVirtualRc", "virtual_rc", SIGKILL, false},
                                           Case{"KilledOnMovement", "movement", SIGKILL, false},
                                           Case{"KilledOnMovementEncrypted", "movement", SIGKILL, true},
                                           Case{"KilledOnVirtualRcEncrypted", "virtual_rc", SIGKILL, true},
                                           Case{"BrokenOnVirtualRc", "virtual_rc", SIGSEGV, false},
                                           Case{"BrokenOnMovement", "movement", SIGSEGV, false},
                                           Case{"AbortedOnMovement", "movement", SIGABRT, false},
                                           Case{"StoppedOnVirtualRc", "virtual_rc", SIGSTOP, false},
                                           Case{"StoppedOnMovement", "movement", SIGSTOP, false},
                                           Case{"StoppedOnMovementEncrypted", "movement", SIGSTOP, true}),
                         [](const auto& tested) { return tested.param.name; });

TEST_P(DeathInFlight, GivesThePilotHisSticks) {
  RecordProperty("promise", "R15");
  in_real_time([&] {
    const auto autopilot = start_autopilot(key());
    Process program(M100_PROGRAM, flight(with({"--channel", GetParam().channel, "--hold", "60"}, key())), errors);
    ASSERT_TRUE(wait_for_control()) << error();
    std::this_thread::sleep_for(std::chrono::seconds(1));
    ASSERT_EQ(noted("\"released\""), 0U) << "it flies";
    StallMeter machine;
    const Clock::time_point died = Clock::now();
    program.send(GetParam().signal);
    const std::optional<double> taken_s = seconds_until_released(died);
    ASSERT_TRUE(taken_s) << "control was not given back; " << error();
    RecordProperty("seconds_until_the_transmitter_had_control", std::to_string(*taken_s));
    const double stall_s = machine.longest_s();
    RecordProperty("stall_of_the_machine_s", std::to_string(stall_s));
    EXPECT_LE(*taken_s, kGivenBack_s + 5.0 * stall_s) << "tolerance: each of the five processes may have waited";
    EXPECT_NE(error().find("control was given back"), std::string::npos) << "the operator is not told: " << error();
    const Json examiner = examined(*autopilot);
    EXPECT_EQ(examiner["client_in_control"], false);
    EXPECT_EQ(examiner["bad_commands"], 0) << examiner;
  });
}

// The stopped program resumes after control is gone. It must not send another command, nor request control.
TEST_F(ProgramTest, AProgramThatWasStoppedStaysOutOfControl) {
  RecordProperty("promise", "R15");
  in_real_time([&] {
    const auto autopilot = start_autopilot();
    Process program(M100_PROGRAM, flight({"--channel", "movement", "--hold", "60"}), errors);
    ASSERT_TRUE(wait_for_control());
    std::this_thread::sleep_for(std::chrono::seconds(1));
    const std::size_t asked = noted("\"control\"");
    program.send(SIGSTOP);
    ASSERT_TRUE(wait_for("\"released\""));
    program.send(SIGCONT);
    std::this_thread::sleep_for(std::chrono::seconds(3));
    program.interrupt();
    EXPECT_GE(program.wait(), 0) << "the program does not end by itself";
    EXPECT_EQ(noted("\"obtained\""), 1U) << "it requested control again by itself; requests before: " << asked;
    const Json examiner = examined(*autopilot);
    EXPECT_EQ(examiner["client_in_control"], false);
    EXPECT_EQ(examiner["control_after_loss"], 0);
  });
}

// The backup process closes the port after its last release.
TEST_F(ProgramTest, AfterADeathTheNextFlightCanBegin) {
  RecordProperty("promise", "R15");
  in_real_time([&] {
    const auto autopilot = start_autopilot();
    Process program(M100_PROGRAM, flight({"--hold", "60"}), errors);
    ASSERT_TRUE(wait_for_control());
    program.send(SIGKILL);
    ASSERT_TRUE(wait_for("\"released\""));
    int code = 2;
    for (int attempt = 0; attempt < 20 && code == 2;
         ++attempt) {  // refused while the backup process repeats its releases
      std::this_thread::sleep_for(milliseconds(500));
      code = run(flight({"--hold", "1"}));
    }
    EXPECT_EQ(code, 0) << error();
    EXPECT_EQ(examined(*autopilot)["client_in_control"], false);
  });
}

// Ctrl-C reaches the whole process group: the program must end normally, and the second process with it.
TEST_F(ProgramTest, AnInterruptOfTheGroupEndsBothAndLeavesNobody) {
  RecordProperty("promise", "R15");
  in_real_time([&] {
    ASSERT_EQ(prctl(PR_SET_CHILD_SUBREAPER, 1), 0) << "needed so that a remaining process becomes our child";
    const auto autopilot = start_autopilot();
    std::vector<std::string> arguments = flight({"--hold", "60"});
    arguments.insert(arguments.begin(), M100_PROGRAM);
    Process program("/usr/bin/setsid", arguments, errors);  // its own process group, with the program's id
    ASSERT_TRUE(wait_for_control());
    std::this_thread::sleep_for(std::chrono::seconds(1));
    ASSERT_EQ(kill(-program.id(), SIGINT), 0);
    EXPECT_EQ(program.wait(), 0) << error();
    EXPECT_TRUE(error().empty()) << "unexpected messages: " << error();
    EXPECT_EQ(examined(*autopilot)["client_in_control"], false);
    EXPECT_EQ(waitpid(-1, nullptr, WNOHANG), -1) << "a process remained";
  });
}

}  // namespace
}  // namespace m100::scenario
