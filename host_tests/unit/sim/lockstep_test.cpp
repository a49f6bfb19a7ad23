// SPDX-License-Identifier: BSD-3-Clause
// Simulated ports, which also carry time: a program behind a port, and the host that keeps its time.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/inotify.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <array>
#include <bit>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "hal/linux/serial_port.h"
#include "host_tests/sim/ports/lockstep_host.h"

namespace m100::sim {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using Bytes = std::array<std::byte, 8>;

constexpr double kPatience_s = 60.0;  // only a failing test waits that long

core::Duration machine_time() {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return core::Duration{std::int64_t{now.tv_sec} * 1000000 + now.tv_nsec / 1000};
}

struct Lockstep : ::testing::Test {
  const std::string path = (std::filesystem::temp_directory_path() / "m100_lockstep").string();
  const std::string port = "sim:" + path;
  LockstepHost host;
  LockstepHost::End end = host.add_end(path);
  std::vector<pid_t> children;

  /// Runs a program as a child process of the test. @returns its process id.
  pid_t start(const std::function<void()>& program) {
    const pid_t child = ::fork();
    if (child == 0) {
      program();
      ::_exit(0);
    }
    children.push_back(child);
    return child;
  }
  void TearDown() override {
    for (const pid_t child : children) {
      finish(child);
    }
  }
  bool comes(pid_t child) {
    return host.wait_for([&] { return host.is_attached(child) && host.connected(end); }, kPatience_s);
  }
  static void finish(pid_t child) {
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
  }
};

Bytes bytes_of(std::uint64_t number) { return std::bit_cast<Bytes>(number); }

/// Runs ticks of 10 ms. Answers the number that came within a tick, and writes 0 if none or several came.
void answer_each_tick(const std::string& port) {
  hal::SerialPort uart(port, 115200);
  hal::PortClock clock(port);
  (void)uart.open();
  for (core::TimePoint tick{};; tick += milliseconds(10)) {
    clock.sleep_until(tick);
    Bytes got{};
    std::array<std::byte, 64> more{};
    const bool one = uart.read(got).value_or(0) == got.size() && uart.read(more).value_or(0) == 0;
    (void)uart.write(one && clock.now() == tick ? got : Bytes{});
  }
}

// Catches a socket name that exists before the socket listens: on a busy machine, a program that waited for the name
// was refused.
TEST_F(Lockstep, ASocketGetsItsNameWhenItListens) {
  const std::filesystem::path seen = path + "_seen";
  std::filesystem::create_directory(seen);
  const int watch = ::inotify_init1(IN_NONBLOCK | IN_CLOEXEC);
  ASSERT_GE(::inotify_add_watch(watch, seen.c_str(), IN_CREATE | IN_MOVED_TO), 0);
  {
    LockstepHost another;
    (void)another.add_end(seen / "w");
  }
  alignas(inotify_event) std::array<char, 4096> events{};
  const ssize_t size = ::read(watch, events.data(), events.size());
  ::close(watch);
  std::filesystem::remove_all(seen);
  std::uint32_t how = 0;  // how the name appeared
  for (ssize_t at = 0; at < size;) {
    inotify_event event{};
    std::memcpy(&event, events.data() + at, sizeof(event));
    if (std::strcmp(events.data() + at + static_cast<ssize_t>(sizeof(event)), "w") == 0) {
      how |= event.mask;
    }
    at += static_cast<ssize_t>(sizeof(event) + event.len);
  }
  EXPECT_EQ(how, static_cast<std::uint32_t>(IN_MOVED_TO));
}

TEST_F(Lockstep, NoByteComesLaterThanTheTimeItBelongsTo) {
  const pid_t child = start([&] { answer_each_tick(port); });
  ASSERT_TRUE(comes(child));
  constexpr std::uint64_t kRounds = 5000;
  for (std::uint64_t round = 1; round <= kRounds; ++round) {
    host.give(end, bytes_of(round));
    host.advance(host.now() + seconds(1));
    const std::vector<std::byte> answer = host.take(end);
    ASSERT_EQ(answer.size(), sizeof(Bytes)) << round;
    Bytes got{};
    std::copy(answer.begin(), answer.end(), got.begin());
    ASSERT_EQ(std::bit_cast<std::uint64_t>(got), round);
    ASSERT_EQ(host.now(), core::TimePoint{(static_cast<int>(round) - 1) * milliseconds(10)});
  }
}

// Catches a flight program that accepts a simulated time over a port that carries a real aircraft.
TEST_F(Lockstep, ARealPortHasNoClockButTheMachines) {
  const core::Duration before = machine_time();
  hal::PortClock real("/dev/ttyUSB0");
  const core::Duration constructed = machine_time();
  const pid_t child = start([&] { answer_each_tick(port); });
  std::thread here([&] {  // this process also follows the host's time, for 100 s
    hal::PortClock simulated(port);
    simulated.sleep_until(core::TimePoint{seconds(100)});
    host.stop();  // it does not sleep again
  });
  ASSERT_TRUE(host.wait_for([&] { return host.is_attached(::getpid()) && host.is_attached(child); }, kPatience_s));
  while (host.now() < core::TimePoint{seconds(100)}) {
    host.advance(core::TimePoint{seconds(100)});
  }
  here.join();
  const core::Duration asked = machine_time();
  const core::TimePoint reported = real.now();
  const core::Duration after = machine_time();
  EXPECT_GE(reported.time_since_epoch(), asked - constructed);
  EXPECT_LE(reported.time_since_epoch(), after - before);
}

TEST_F(Lockstep, APortIsHeldByOneProgramAndComesBackWhereItWasPluggedInAgain) {
  const pid_t child = start([&] {
    hal::SerialPort uart(port, 230400);
    hal::PortClock clock(port);
    (void)uart.open();
    hal::SerialPort second(port, 230400);
    const std::byte refused{second.open() == core::Status::kRefused ? std::uint8_t{1} : std::uint8_t{2}};
    (void)uart.write(std::span(&refused, 1));
    std::array<std::byte, 8> bytes{};
    for (core::TimePoint tick{};; tick += milliseconds(10)) {
      clock.sleep_until(tick);
      const core::Expected<std::size_t> got = uart.read(bytes);
      const std::byte state{got ? std::uint8_t{3} : std::uint8_t{4}};
      (void)uart.write(std::span(&state, 1));
    }
  });
  ASSERT_TRUE(comes(child));
  EXPECT_EQ(host.baud(end), 230400U);
  host.advance(host.now() + seconds(1));
  EXPECT_EQ(host.take(end), (std::vector<std::byte>{std::byte{1}, std::byte{3}}));
  host.unplug(end);
  const core::TimePoint unplugged = host.now();
  while (host.now() < unplugged + milliseconds(500)) {
    host.advance(host.now() + seconds(1));
    EXPECT_FALSE(host.connected(end));
  }
  host.plug_in(end);
  const core::TimePoint plugged_in = host.now();
  while (!host.connected(end) && host.now() < plugged_in + seconds(1)) {
    host.advance(host.now() + seconds(1));
  }
  EXPECT_LE(host.now() - plugged_in, hal::SerialPort::kReopenInterval + milliseconds(10));
}

TEST_F(Lockstep, TimeGoesOnWithoutAProgramThatIsStoppedAndWithoutOneThatIsKilled) {
  const pid_t child = start([&] { answer_each_tick(port); });
  ASSERT_TRUE(comes(child));
  host.advance(host.now() + seconds(1));
  host.advance(host.now() + seconds(1));
  host.suspend(child);
  host.advance(core::TimePoint{seconds(5)});
  EXPECT_EQ(host.now(), core::TimePoint{seconds(5)});
  host.resume(child);
  (void)host.take(end);
  host.advance(core::TimePoint{seconds(6)});
  EXPECT_EQ(host.now(), core::TimePoint{seconds(5)}) << "it is late, and woken at once";
  EXPECT_EQ(host.take(end).size(), sizeof(Bytes));
  ::kill(child, SIGSTOP);  // the host is not told
  host.advance(core::TimePoint{seconds(7)});
  host.advance(core::TimePoint{seconds(7)});
  EXPECT_EQ(host.now(), core::TimePoint{seconds(7)});
  finish(child);
  host.advance(core::TimePoint{seconds(8)});
  host.advance(core::TimePoint{seconds(8)});
  EXPECT_EQ(host.now(), core::TimePoint{seconds(8)});
  EXPECT_EQ(host.attached_count(), 0U);
}

}  // namespace
}  // namespace m100::sim
