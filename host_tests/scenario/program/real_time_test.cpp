// SPDX-License-Identifier: BSD-3-Clause
// What counts of a flight in real time: a failure on a machine that kept pace, and nothing on one that stalled.
#include "host_tests/scenario/program/real_time.h"

namespace m100::scenario {
namespace {

/// A machine that stalls in its first flights, as many as are asked for.
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
  EXPECT_EQ(flights.flown, 1) << "nothing is tried until it passes";
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

TEST(RealTime, ADefectIsFoundBehindStalls) {
  static Flights flights;
  EXPECT_NONFATAL_FAILURE_ON_ALL_THREADS(flights.judge(kAttempts - 1, kAttempts), "it came down");
  EXPECT_EQ(flights.flown, kAttempts);
}

}  // namespace
}  // namespace m100::scenario
