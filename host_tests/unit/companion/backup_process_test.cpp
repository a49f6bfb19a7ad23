// SPDX-License-Identifier: BSD-3-Clause
// The backup process, the second process of a flight, with a pipe in place of the port: what it sends, when it sends,
// and when it stays silent.
#include "firmware/companion/backup/backup_process.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <new>
#include <set>
#include <vector>

#include "protocol/dji/command_decoder.h"
#include "protocol/dji/commands.h"
#include "protocol/dji/frame_parser.h"

namespace {

/// The only process that may use the heap; 0: all may.
pid_t only_process = 0;

void* allocate(std::size_t size) {
  if (only_process != 0 && getpid() != only_process) {
    _exit(99);  // the test then finds a backup process that is dead and has sent nothing
  }
  return std::malloc(size);
}

}  // namespace

void* operator new(std::size_t size) { return allocate(size); }
void* operator new[](std::size_t size) { return allocate(size); }
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }

namespace m100::companion {
namespace {

constexpr int kPatience_ms = 20000;  ///< of a busy machine
const link::ChannelCommand kSticks{vrc::Sticks{}};

/// What an autopilot would have received.
struct Heard {
  int sticks = 0;
  int movements = 0;
  int switched_off = 0;
  std::vector<std::uint16_t> releases;  ///< their sequence numbers
  int others = 0;
};

Heard understood(const std::vector<std::byte>& bytes) {
  Heard heard;
  protocol::FrameParser parser;
  protocol::CipherScratch scratch{};
  for (const std::byte value : bytes) {
    const core::Expected<protocol::FrameView> frame = parser.push(value);
    if (!frame) {
      continue;
    }
    const core::Expected<protocol::Message> message = protocol::open(*frame, nullptr, scratch);
    const core::Expected<protocol::Command> command = protocol::decode_command(message->id, message->value);
    if (const auto* request = std::get_if<protocol::ControlRequest>(&*command); request && !request->obtain) {
      heard.releases.push_back(frame->header.sequence);
    } else if (const auto* off = std::get_if<protocol::VirtualRcSwitch>(&*command); off && !off->on) {
      ++heard.switched_off;
    } else if (std::holds_alternative<protocol::VirtualRcData>(*command)) {
      ++heard.sticks;
    } else if (std::holds_alternative<protocol::Movement>(*command)) {
      ++heard.movements;
    } else {
      ++heard.others;
    }
  }
  return heard;
}

struct BackupProcessTest : ::testing::Test {
  int line[2]{-1, -1};  ///< what the backup process writes comes out at [0]
  void SetUp() override { ASSERT_EQ(pipe2(line, O_CLOEXEC | O_NONBLOCK), 0); }
  void TearDown() override {
    only_process = 0;
    close(line[0]);
    close(line[1]);
  }
  /// Reads until every writer has closed the line or, if `bytes` is given, until that many bytes have come.
  std::vector<std::byte> read_line(std::size_t bytes = ~std::size_t{0}) {
    std::vector<std::byte> all;
    std::array<std::byte, 4096> some{};
    for (pollfd come{.fd = line[0], .events = POLLIN, .revents = 0}; all.size() < bytes;) {
      EXPECT_GT(poll(&come, 1, kPatience_ms), 0) << "neither bytes nor an end";
      const ssize_t count = read(line[0], some.data(), some.size());
      if (count <= 0) {
        break;
      }
      all.insert(all.end(), some.begin(), some.begin() + count);
    }
    return all;
  }
  /// Runs `flight` as the flying program, in a process of its own. @returns its id.
  template <typename Flight>
  pid_t fly(const Flight& flight) {
    const pid_t program = fork();
    if (program == 0) {
      only_process = getpid();
      flight();
      _exit(0);
    }
    close(line[1]);
    line[1] = -1;
    return program;
  }
};

struct Death {
  const char* name;
  int signal;
  link::ChannelCommand neutral;
};
class BackupAfterDeath : public BackupProcessTest, public ::testing::WithParamInterface<Death> {};
INSTANTIATE_TEST_SUITE_P(Signals, BackupAfterDeath,
                         ::testing::Values(Death{"KilledOnVirtualRc", SIGKILL, kSticks},
                                           Death{"KilledOnMovement", SIGKILL, ctl::Command<double>{}},
                                           Death{"AbortedOnVirtualRc", SIGABRT, kSticks},
                                           Death{"BrokenOnMovement", SIGBUS, ctl::Command<double>{}}),
                         [](const auto& tested) { return tested.param.name; });

TEST_P(BackupAfterDeath, SaysTheWholeFarewellAFewTimesAndEnds) {
  RecordProperty("promise", "R15");
  const pid_t program = fly([&] {
    signal(GetParam().signal, SIG_DFL);
    BackupProcess backup(GetParam().neutral, nullptr);
    backup.set_port(line[1], 1);
    (void)backup.heartbeat(true);
    kill(getpid(), GetParam().signal);
  });
  const Heard heard = understood(read_line());  // ends only when the backup process has closed the line
  waitpid(program, nullptr, 0);
  EXPECT_EQ(heard.releases.size(), 2 * BackupProcess::kRounds);
  EXPECT_EQ(std::set<std::uint16_t>(heard.releases.begin(), heard.releases.end()).size(), BackupProcess::kRounds)
      << "the autopilot executes a number once";
  const bool sticks = std::holds_alternative<vrc::Sticks>(GetParam().neutral);
  EXPECT_EQ(heard.switched_off, sticks ? static_cast<int>(BackupProcess::kRounds) : 0);
  EXPECT_LE(heard.sticks + heard.movements, 1) << "a command only while the last tick's word about control holds";
  EXPECT_EQ(sticks ? heard.movements : heard.sticks, 0);
  EXPECT_EQ(heard.others, 0);
}

TEST_F(BackupProcessTest, SaysNoCommandWhereControlWasNotOurs) {
  RecordProperty("promise", "R4");
  const pid_t program = fly([&] {
    BackupProcess backup(kSticks, nullptr);
    backup.set_port(line[1], 1);
    (void)backup.heartbeat(false);
    kill(getpid(), SIGKILL);
  });
  const Heard heard = understood(read_line());
  waitpid(program, nullptr, 0);
  EXPECT_EQ(heard.releases.size(), 2 * BackupProcess::kRounds);
  EXPECT_EQ(heard.sticks, 0);
}

TEST_F(BackupProcessTest, DismissedItEndsWithoutAWordAndWithoutAZombie) {
  const pid_t program = fly([&] {
    BackupProcess backup(kSticks, nullptr);
    backup.set_port(line[1], 1);
    const pid_t second = backup.process();
    (void)backup.heartbeat(true);
    backup.dismiss();
    if (waitpid(second, nullptr, WNOHANG) != -1 || errno != ECHILD || kill(second, 0) == 0) {
      _exit(1);
    }
  });
  EXPECT_TRUE(read_line().empty());
  int status = 0;
  waitpid(program, &status, 0);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
}

// The program ends without knowing whether the pilot has control again.
TEST_F(BackupProcessTest, AskedToReleaseItGivesBackAndEnds) {
  RecordProperty("promise", "R15");
  const pid_t program = fly([&] {
    BackupProcess backup(kSticks, nullptr);
    backup.set_port(line[1], 1);
    (void)backup.heartbeat(false);
    backup.send_release();
    if (backup.alive()) {
      _exit(1);
    }
  });
  const Heard heard = understood(read_line());
  EXPECT_EQ(heard.releases.size(), 2 * BackupProcess::kRounds);
  EXPECT_EQ(heard.sticks, 0);
  int status = 0;
  waitpid(program, &status, 0);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
}

// The program's heartbeats stop, then it resumes: it must notice that the backup process has spoken, once.
TEST_F(BackupProcessTest, SpeaksWhenTheBeatsStopAndIsNoticedOnce) {
  RecordProperty("promise", "R15");
  only_process = getpid();
  BackupProcess backup(kSticks, nullptr);
  backup.set_port(line[1], 1);
  ASSERT_TRUE(backup.heartbeat(true));
  const std::vector<std::byte> bytes = read_line(1);
  const Heard heard = understood(bytes);
  EXPECT_EQ(heard.releases.size(), 2U);
  EXPECT_EQ(heard.sticks, 0) << "nobody knows who has control by now";
  EXPECT_FALSE(backup.heartbeat(true)) << "it has spoken";
  EXPECT_TRUE(backup.heartbeat(true)) << "it is noticed once";
  EXPECT_FALSE(understood(read_line(1)).releases.empty()) << "and it watches over the beats that have come since";
  EXPECT_TRUE(backup.alive());
}

TEST_F(BackupProcessTest, SpeaksAFewTimesOfOneHangAndThenNoMore) {
  only_process = getpid();
  BackupProcess backup(kSticks, nullptr);
  backup.set_port(line[1], 1);
  ASSERT_TRUE(backup.heartbeat(true));
  std::size_t releases = 0;
  while (releases < 2 * BackupProcess::kRounds) {
    releases += understood(read_line(1)).releases.size();
  }
  pollfd come{.fd = line[0], .events = POLLIN, .revents = 0};
  EXPECT_EQ(poll(&come, 1, 1500), 0) << "four rounds, and silence";
  EXPECT_EQ(releases, 2 * BackupProcess::kRounds);
}

// The flying program must notice that its backup process would not act in its place. The test passes the times in.
TEST_F(BackupProcessTest, ThatStandsStillOrIsDeadIsNoticed) {
  RecordProperty("promise", "R15");
  only_process = getpid();
  BackupProcess backup(kSticks, nullptr);
  const core::TimePoint from = core::TimePoint{} + std::chrono::seconds(1);
  const auto looks_again = [&] {  // it checks fifty times a second; the machine may be busy
    for (int tries = 0;
         tries < 2000 && backup.state(from + BackupProcess::kHeartbeatTimeout) != BackupProcess::State::kReady;
         ++tries) {
      usleep(10000);
    }
    return backup.state(from + BackupProcess::kHeartbeatTimeout);
  };
  EXPECT_EQ(backup.state(from), BackupProcess::State::kReady);
  ASSERT_EQ(kill(backup.process(), SIGSTOP), 0);
  int status = 0;
  ASSERT_EQ(waitpid(backup.process(), &status, WUNTRACED), backup.process());
  (void)backup.state(from);  // takes in what the backup process did before it was stopped
  EXPECT_EQ(backup.state(from + BackupProcess::kHeartbeatTimeout - core::Duration{1}), BackupProcess::State::kReady);
  EXPECT_EQ(backup.state(from + BackupProcess::kHeartbeatTimeout), BackupProcess::State::kStalled);
  ASSERT_EQ(kill(backup.process(), SIGCONT), 0);
  EXPECT_EQ(looks_again(), BackupProcess::State::kReady);
  ASSERT_EQ(kill(backup.process(), SIGKILL), 0);
  siginfo_t ended{};
  ASSERT_EQ(waitid(P_PID, static_cast<id_t>(backup.process()), &ended, WEXITED | WNOWAIT), 0);
  (void)backup.state(from + 2 * BackupProcess::kHeartbeatTimeout);
  EXPECT_EQ(backup.state(from + 4 * BackupProcess::kHeartbeatTimeout), BackupProcess::State::kDead);
}

// Catches a backup process that acts during start-up, which may take long; control is not held yet.
TEST_F(BackupProcessTest, IsSilentBeforeTheFirstBeat) {
  only_process = getpid();
  BackupProcess backup(kSticks, nullptr);
  backup.set_port(line[1], 1);
  pollfd come{.fd = line[0], .events = POLLIN, .revents = 0};
  EXPECT_EQ(poll(&come, 1, 1500), 0);
  EXPECT_TRUE(backup.alive());
}

// Ctrl-C and a closed terminal send a signal to every process of the group.
TEST_F(BackupProcessTest, IsDeafToSignalsOfTheGroup) {
  RecordProperty("promise", "R15");
  const pid_t program = fly([&] {
    BackupProcess backup(kSticks, nullptr);
    backup.set_port(line[1], 1);
    (void)backup.heartbeat(false);
    usleep(50000);  // by now it must have left the group; otherwise the signals below kill it
    for (const int number : {SIGINT, SIGHUP, SIGQUIT, SIGTERM, SIGPIPE, SIGUSR1, SIGALRM, SIGTSTP}) {
      kill(backup.process(), number);
    }
    usleep(50000);
    if (!backup.alive() || getpgid(backup.process()) == getpgid(0)) {
      _exit(1);
    }
    kill(getpid(), SIGKILL);
  });
  EXPECT_EQ(understood(read_line()).releases.size(), 2 * BackupProcess::kRounds);
  int status = 0;
  waitpid(program, &status, 0);
  EXPECT_TRUE(WIFSIGNALED(status)) << "it was dead, or in the group";
}

// A port that was unplugged and plugged in again has another descriptor; the backup process must close the old one.
TEST_F(BackupProcessTest, HoldsThePortThatIsAndLetsGoOfTheOneThatWas) {
  int old_line[2]{-1, -1};
  ASSERT_EQ(pipe2(old_line, O_CLOEXEC | O_NONBLOCK), 0);
  const pid_t program = fly([&] {
    close(old_line[0]);
    BackupProcess backup(kSticks, nullptr);
    backup.set_port(old_line[1], 1);
    backup.set_port(-1, 1);
    close(old_line[1]);
    backup.set_port(line[1], 2);
    (void)backup.heartbeat(false);
    kill(getpid(), SIGKILL);
  });
  close(old_line[1]);
  EXPECT_EQ(understood(read_line()).releases.size(), 2 * BackupProcess::kRounds);
  waitpid(program, nullptr, 0);
  std::byte byte{};
  EXPECT_EQ(read(old_line[0], &byte, 1), 0) << "at its end: nobody holds it";
  close(old_line[0]);
}

// Catches a program that asks for control before its second process runs: if the program dies then, the second process
// dies too.
TEST_F(BackupProcessTest, ItStandsBeforeAnythingIsAskedFor) {
  for (int i = 0; i < 20; ++i) {
    BackupProcess backup(kSticks, nullptr);
    EXPECT_EQ(getsid(backup.process()), backup.process()) << "it has left our session, and with it our signals";
    backup.dismiss();
  }
}

}  // namespace
}  // namespace m100::companion
