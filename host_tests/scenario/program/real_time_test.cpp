// SPDX-License-Identifier: BSD-3-Clause
// Tests judge_in_real_time: a failure counts on a machine that did not stall, and never on one that stalled.
#include "host_tests/scenario/program/real_time.h"

#include <sched.h>
#include <unistd.h>

#include "host_tests/scenario/program/process.h"

namespace m100::scenario {
namespace {

/// A machine that stalls in its first `flights_left` flights.
struct Stalling {
  static inline int flights_left = 0;
  double longest_s() const { return flights_left-- > 0 ? kStall_s : 0.0; }
};

struct Flights {
  int begun_again = 0;
  int flown = 0;
  /// Flies on a machine that stalls `stalls` times; each of the first `bad` flights fails.
  void judge(int stalls, int bad) {
    Stalling::flights_left = stalls;
    judge_in_real_time<Stalling>([this] { ++begun_again; },
                                 [this, bad] { EXPECT_GE(++flown, bad + 1) << "it came down"; });
  }
};

TEST(RealTime, AFailureOnAMachineThatKeptPaceIsAFailure) {
  static Flights flights;
  EXPECT_NONFATAL_FAILURE_ON_ALL_THREADS(flights.judge(0, 1), "it came down");
  EXPECT_EQ(flights.flown, 1) << "a real failure must not be repeated";
}

TEST(RealTime, AFailureInAStallIsFlownAgainInAClearedPlace) {
  Flights flights;
  flights.judge(2, 2);
  EXPECT_EQ(flights.flown, 3);
  EXPECT_EQ(flights.begun_again, 2);
}

TEST(RealTime, AFlightThatPassedInAStallHasPassed) {
  Flights flights;
  flights.judge(1, 0);
  EXPECT_EQ(flights.flown, 1);
}

// Two computing programs on one processor each wait half of the time; the meter's own thread may not wait.
TEST(RealTime, SeesAProgramThatWaitsWhileOthersRun) {
  cpu_set_t all, one;
  ASSERT_EQ(sched_getaffinity(0, sizeof all, &all), 0);
  CPU_ZERO(&one);
  for (std::size_t i = 0; CPU_COUNT(&one) == 0; ++i) {
    if (CPU_ISSET(i, &all)) {
      CPU_SET(i, &one);
    }
  }
  if (RunDelays::now().count(getpid()) == 0) {
    GTEST_SKIP() << "this kernel does not count the waiting time of threads";
  }
  StallMeter machine;
  {
    ASSERT_EQ(sched_setaffinity(0, sizeof one, &one), 0);
    const Process first("/bin/sh", {"-c", "while :; do :; done"});
    const Process second("/bin/sh", {"-c", "while :; do :; done"});
    ASSERT_EQ(sched_setaffinity(0, sizeof all, &all), 0);
    std::this_thread::sleep_for(std::chrono::seconds(2));
  }
  EXPECT_GE(machine.longest_s(), kStall_s);
}

// Catches a meter that throws where a process ends between opening and reading its file: the exception left the meter's
// thread, and the test program died with the flight still going on. Reading this file fails every time.
TEST(RealTime, AFileThatCannotBeReadIsNoException) { EXPECT_EQ(RunDelays::text("/proc/self/mem"), ""); }

TEST(RealTime, ADefectIsFoundBehindStalls) {
  static Flights flights;
  EXPECT_NONFATAL_FAILURE_ON_ALL_THREADS(flights.judge(kAttempts - 1, kAttempts), "it came down");
  EXPECT_EQ(flights.flown, kAttempts);
}

}  // namespace
}  // namespace m100::scenario
