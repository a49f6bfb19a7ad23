// SPDX-License-Identifier: BSD-3-Clause
// The clock of a source of pose is set, slewed or exchanged in flight, at any rate and jitter of the source.
#include "firmware/est/timing/pose_clock.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "firmware/link/pose/stamp_order.h"

namespace m100::est {
namespace {

using core::seconds;
core::TimePoint at(double s) { return core::TimePoint(core::Duration(std::llround(s * 1e6))); }

/// One flight of 30 s: poses go through the order of the stamps into the clock, as PoseLink and PoseTiming do it.
struct Flight {
  double rate_hz = 100.0;
  double jitter_s = 0.004;
  double drift_ppm = 0.0;
  double lost_share = 0.0;
  std::function<double(double)> clock_s = [](double) { return 0.0; };  ///< error of the sender's clock at a time [s]
  std::function<double(double)> later_s = [](double) { return 0.0; };  ///< additional transport delay at a time [s]
  unsigned seed = 1;
  bool is_numbered_on_line = false;  ///< frames are numbered when they leave, not when the pose is captured

  double worst_s = 0.0;        ///< largest error of the times of capture that count
  double longest_gap_s = 0.0;  ///< longest time between two poses that were taken
  PoseClock clock{};

  void fly(const std::function<bool(double)>& counts) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<> uniform;
    struct Sent {
      double captured_s, arrives_s;
      core::SenderTime stamp;
      std::uint8_t frame;
    };
    std::vector<Sent> sent;
    const double phase_s = uniform(random) / rate_hz;
    for (int n = 0; n < static_cast<int>(30.0 * rate_hz); ++n) {
      const double captured_s = phase_s + n / rate_hz;
      const double way_s = 0.02 + jitter_s * uniform(random) + later_s(captured_s);
      if (uniform(random) < lost_share) {
        continue;
      }
      const double stamp_s = captured_s * (1.0 + 1e-6 * drift_ppm) + clock_s(captured_s);
      sent.push_back({captured_s, captured_s + way_s,
                      core::SenderTime(core::SenderClock::duration(1763757191000000 + std::llround(stamp_s * 1e6))),
                      static_cast<std::uint8_t>(n)});
    }
    std::stable_sort(sent.begin(), sent.end(), [](const Sent& a, const Sent& b) { return a.arrives_s < b.arrives_s; });
    for (std::size_t n = 0; is_numbered_on_line && n < sent.size(); ++n) {
      sent[n].frame = static_cast<std::uint8_t>(n);
    }
    link::StampOrder order;
    double last_s = 0.0;
    bool was_set = false;
    for (const Sent& one : sent) {
      const double tick_s = std::ceil(one.arrives_s * 100.0) / 100.0;  // arrivals are known to one tick
      const link::StampOrder::Verdict verdict = order.judge(one.stamp, one.frame, at(tick_s));
      if (verdict == link::StampOrder::Verdict::kRefused) {
        continue;
      }
      was_set = verdict == link::StampOrder::Verdict::kSet;
      const core::TimePoint found = clock.update(one.stamp, at(tick_s), {.clock_was_set = was_set, .poses = 1});
      longest_gap_s = std::max(longest_gap_s, last_s > 0.0 ? tick_s - last_s : 0.0);
      last_s = tick_s;
      if (counts(one.captured_s)) {
        worst_s = std::max(worst_s, std::abs(seconds<double>(found - at(one.captured_s + 0.02))));
      }
    }
  }
};

/// Half a second after the event begins, and always after it.
bool from_s(double t, double event_s) { return t > event_s + 0.5; }

std::string named(const Flight& flight, double value) {
  return std::to_string(value) + " at " + std::to_string(flight.rate_hz) + " Hz, jitter " +
         std::to_string(flight.jitter_s);
}

struct Source {
  double rate_hz;
  double jitter_s;
  double lost_share;
};
constexpr std::array kSources{Source{30.0, 0.004, 0.0}, Source{30.0, 0.03, 0.05}, Source{50.0, 0.02, 0.0},
                              Source{100.0, 0.0, 0.0},  Source{100.0, 0.02, 0.0}, Source{100.0, 0.01, 0.1},
                              Source{97.0, 0.04, 0.0}};

// Bounds: a tick by which the arrivals are known and another for the offset, the jitter, and for a slew two windows of
// eight poses and what can be seen.
//
// Would catch a clock that takes a step for jitter, a rate or a late pose, and an order of stamps that refuses good
// poses for longer than 0.3 s.
TEST(PoseClockSet, StepsOf10MillisecondsTo10SecondsChangeNoTimeOfCapture) {
  for (const Source& source : kSources) {
    for (const double step_s : {0.01, 0.015, 0.05, 0.1, 0.15, 0.25, 0.3, 1.0, 5.0, 9.9, 10.1, 3600.0}) {
      for (const double sign : {1.0, -1.0}) {
        Flight flight{.rate_hz = source.rate_hz, .jitter_s = source.jitter_s, .lost_share = source.lost_share};
        flight.clock_s = [&](double t) { return t > 12.0 ? sign * step_s : 0.0; };
        flight.fly([](double t) { return from_s(t, 12.0); });
        EXPECT_LT(flight.worst_s, 0.02 + source.jitter_s) << named(flight, sign * step_s);
        EXPECT_LE(flight.longest_gap_s, 0.3) << named(flight, sign * step_s);
        if (step_s > 0.02 + source.jitter_s) {
          EXPECT_NEAR(seconds<double>(flight.clock.set_by()), sign * step_s, 0.012 + source.jitter_s)
              << named(flight, sign * step_s);
        }
      }
    }
  }
}

TEST(PoseClockSet, ASlewOfUpToATenthIsFollowed) {
  for (const Source& source : kSources) {
    for (const double rate : {0.1, 0.05, 0.02, 0.01, 0.003}) {
      for (const double sign : {1.0, -1.0}) {
        Flight flight{.rate_hz = source.rate_hz, .jitter_s = source.jitter_s, .lost_share = source.lost_share};
        flight.clock_s = [&](double t) { return sign * rate * std::clamp(t - 12.0, 0.0, 6.0); };
        flight.fly([](double t) { return t > 12.5; });
        EXPECT_LT(flight.worst_s, 0.03 + source.jitter_s + 16.0 * rate / source.rate_hz) << named(flight, sign * rate);
        EXPECT_LE(flight.longest_gap_s, 0.3) << named(flight, sign * rate);
      }
    }
  }
}

TEST(PoseClockSet, AnotherTimeBaseForSecondsAndSingleWrongStampsCostOnePose) {
  for (const Source& source : kSources) {
    for (const double base_s : {-1.7e9, 5e5, -20.0, 3.3}) {
      Flight flight{.rate_hz = source.rate_hz, .jitter_s = source.jitter_s, .lost_share = source.lost_share};
      flight.clock_s = [&](double t) { return t > 12.0 && t < 15.0 ? base_s : 0.0; };
      flight.fly([](double t) { return from_s(t, 15.0) || (t > 12.5 && t < 15.0); });
      EXPECT_LT(flight.worst_s, 0.02 + source.jitter_s) << named(flight, base_s);
      EXPECT_LE(flight.longest_gap_s, 0.3) << named(flight, base_s);
      Flight single{.rate_hz = source.rate_hz, .jitter_s = source.jitter_s, .lost_share = source.lost_share};
      single.clock_s = [&](double t) { return t > 12.0 && t <= 12.0 + 1.0 / source.rate_hz ? base_s : 0.0; };
      single.fly([](double t) { return t > 5.0; });
      EXPECT_LT(single.worst_s, 0.02 + source.jitter_s) << named(single, base_s);
      EXPECT_LE(single.longest_gap_s, 0.3) << named(single, base_s);
    }
  }
}

// A healthy source is never said to have a clock that was set, and a late pose is never called fresh.
TEST(PoseClockSet, TransportIsNotTheClock) {
  for (const Source& source : kSources) {
    for (const double later_s : {0.0, 0.05, 0.2, 0.4}) {
      for (const double ppm : {-100.0, 0.0, 100.0, 5000.0}) {
        Flight flight{
            .rate_hz = source.rate_hz, .jitter_s = source.jitter_s, .drift_ppm = ppm, .lost_share = source.lost_share};
        flight.later_s = [&](double t) { return t > 12.0 && t < 20.0 ? later_s * std::min(1.0, t - 12.0) : 0.0; };
        flight.fly([](double t) { return t > 13.5 && t < 20.0; });
        EXPECT_EQ(flight.clock.times_set(), 0U)
            << named(flight, later_s) << " drift " << ppm << " by " << seconds<double>(flight.clock.set_by());
        EXPECT_LT(flight.worst_s, 0.03 + source.jitter_s) << named(flight, later_s) << " drift " << ppm;
      }
    }
  }
}

// Catches a spacing of the stamps that is taken from neighbours on the line, where poses overtake each other.
TEST(PoseClockSet, OvertakenPosesAreNotAClockThatWasSet) {
  for (const double rate_hz : {60.0, 120.0, 200.0, 240.0}) {
    for (unsigned seed = 1; seed <= 20; ++seed) {
      Flight flight{.rate_hz = rate_hz, .jitter_s = 0.04, .seed = seed, .is_numbered_on_line = true};
      flight.fly([](double t) { return t > 5.0; });
      EXPECT_EQ(flight.clock.times_set(), 0U)
          << named(flight, seed) << " by " << seconds<double>(flight.clock.set_by());
    }
  }
}

}  // namespace
}  // namespace m100::est
