// SPDX-License-Identifier: BSD-3-Clause
// DJI's window of rates must hold in every second, whatever its beginning and the jitter. Seeds are printed on failure.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "firmware/link/command_channel.h"
#include "host_tests/sim/ports/link_bench.h"

namespace m100::link {
namespace {

using core::Duration;
using core::TimePoint;

struct Rate {
  const char* name;
  Channel channel;
  double rate_hz;
  std::size_t max_count;  ///< largest number in any second
};

class RateLimits : public ::testing::TestWithParam<Rate> {
 protected:
  RateLimiter limiter() const {
    return RateLimiter(*command_period({.channel = GetParam().channel, .rate_hz = GetParam().rate_hz}));
  }
};
INSTANTIATE_TEST_SUITE_P(Channel, RateLimits,
                         ::testing::Values(Rate{"VirtualRc5", Channel::kVirtualRc, 5, 5},
                                           Rate{"VirtualRc7point3", Channel::kVirtualRc, 7.3, 8},
                                           Rate{"VirtualRc25", Channel::kVirtualRc, 25, 25},
                                           Rate{"Movement1", Channel::kMovement, 1, 1},
                                           Rate{"Movement10", Channel::kMovement, 10, 10},
                                           Rate{"Movement33", Channel::kMovement, 33, 33},
                                           Rate{"Movement50", Channel::kMovement, 50, 50}),
                         [](const auto& tested) { return tested.param.name; });

/// Largest number of commands in any half-open second.
std::size_t max_in_a_second(const std::vector<TimePoint>& times) {
  std::size_t max_count = 0;
  std::size_t first = 0;
  for (std::size_t last = 0; last < times.size(); ++last) {
    while (times[last] - times[first] >= std::chrono::seconds(1)) {
      ++first;
    }
    max_count = std::max(max_count, last - first + 1);
  }
  return max_count;
}

/// Sends whenever the limiter allows it, at ticks that are `next(now)` apart, for a minute.
template <typename Next>
std::vector<TimePoint> send_when_due(RateLimiter limiter, Next&& next) {
  std::vector<TimePoint> times;
  for (TimePoint now{}; now < TimePoint{std::chrono::minutes(1)}; now += next(now)) {
    if (limiter.due(now)) {
      limiter.sent(now);
      times.push_back(now);
    }
  }
  return times;
}

// An adversary that checks continuously and sends at the first allowed moment, with pauses to save up commands.
TEST_P(RateLimits, HoldAgainstOneWhoSendsAtTheFirstMomentHeMay) {
  RecordProperty("promise", "R4");
  for (unsigned seed = 0; seed < 20; ++seed) {
    std::mt19937 random(seed);
    const std::vector<TimePoint> times = send_when_due(limiter(), [&](TimePoint) {
      const bool pauses = seed > 0 && random() % 2000 == 0;
      return pauses ? std::chrono::milliseconds(random() % 3000) : Duration{std::chrono::microseconds(200)};
    });
    ASSERT_LE(max_in_a_second(times), GetParam().max_count) << "seed " << seed;
  }
}

// Ticks of 10 ms with jitter of up to a tick, alternating, in bursts, and with stalls.
TEST_P(RateLimits, HoldUnderAnyJitter) {
  RecordProperty("promise", "R4");
  for (unsigned seed = 0; seed < 200; ++seed) {
    std::mt19937 random(seed);
    const auto jitter_us = static_cast<std::int64_t>(1 + random() % 20000);
    const bool alternates = seed % 3 == 0;
    const bool stalls = seed % 5 == 0;
    std::int64_t tick = 0;
    TimePoint last{};
    const std::vector<TimePoint> times = send_when_due(limiter(), [&](TimePoint now) {
      ++tick;
      const std::int64_t late_us =
          alternates ? (tick % 2) * jitter_us : static_cast<std::int64_t>(random()) % jitter_us;
      tick += stalls && random() % 500 == 0 ? 50 : 0;
      const TimePoint at{std::chrono::milliseconds(10 * tick) + std::chrono::microseconds(late_us)};
      last = std::max(last, at);
      return std::max(last - now, Duration{1});
    });
    ASSERT_LE(max_in_a_second(times), GetParam().max_count) << "seed " << seed;
  }
}

// Catches a limiter that is safe only because it sends too little. A rate whose period is no whole number of ticks
// loses 4 %.
TEST_P(RateLimits, CostAtMostOnePercentAndAHalfOfARateOfWholeTicksUnderUsualJitter) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    std::mt19937 random(seed);
    const std::vector<TimePoint> times = send_when_due(limiter(), [&, tick = std::int64_t{0}](TimePoint now) mutable {
      ++tick;
      const TimePoint at{std::chrono::milliseconds(10 * tick) + std::chrono::microseconds(random() % 500)};
      return at - now;
    });
    const bool whole_ticks = std::fmod(100.0, GetParam().rate_hz) == 0.0;
    EXPECT_GE(static_cast<double>(times.size()), 60.0 * GetParam().rate_hz * (whole_ticks ? 0.985 : 0.96))
        << "seed " << seed;
  }
}

class BothChannels : public ::testing::TestWithParam<Channel> {};
INSTANTIATE_TEST_SUITE_P(RateLimits, BothChannels, ::testing::Values(Channel::kVirtualRc, Channel::kMovement),
                         [](const auto& tested) {
                           return tested.param == Channel::kVirtualRc ? "VirtualRc" : "Movement";
                         });

/// Records when the last byte of each flight command is sent: a line that takes bytes in pieces delays it.
struct SentCommands : ByteTap {
  explicit SentCommands(std::size_t frame_bytes) : frame_bytes_(frame_bytes) {}
  void received(std::span<const std::byte>, TimePoint) override {}
  void sent(std::span<const std::byte> bytes, TimePoint now) override {
    parser_.consume(bytes, [&](const protocol::FrameView& frame) {
      if (frame.bytes.size() == frame_bytes_) {
        times.push_back(now);
      }
    });
  }
  std::vector<TimePoint> times;

 private:
  std::size_t frame_bytes_;
  protocol::FrameParser parser_;
};

/// Blocks the line now and then, and lets the pilot take control for 0.1 s every 15 s.
void disturb(hal::UartPair& cable, sim::N1Autopilot& autopilot, int tick, std::mt19937& random) {
  if (random() % 40 == 0) {
    cable.a_to_b().set_faults({.longest_write = random() % 3 == 0 ? 0U : random() % 60});
  } else if (random() % 20 == 0) {
    cable.a_to_b().set_faults({});
  }
  if (tick % 1500 == 1200) {
    autopilot.set_mode(sim::N1Mode::kA);
  } else if (tick % 1500 == 1210) {
    autopilot.set_mode(sim::N1Mode::kF);
  }
}

// Catches a limiter that counts bytes given to the port instead of sent ones, and one that a new control resets.
TEST_P(BothChannels, HoldOnALineThatSticksAndThroughLossesOfControl) {
  RecordProperty("promise", "R4");
  const std::size_t frame_bytes = GetParam() == Channel::kVirtualRc ? 82 : 35;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    std::mt19937 random(static_cast<unsigned>(seed));
    hal::ManualClock clock;
    sim::StillVehicle vehicle;
    hal::UartPair cable(clock, 230400, seed);
    sim::N1Autopilot autopilot(cable.b(), vehicle, {});
    SentCommands sent(frame_bytes);
    LinkConfig config;
    config.channel.channel = GetParam();
    SerialLink link(cable.a(), config, &sent);
    for (int tick = 0; tick < 6000; ++tick) {
      const std::int64_t step_us = 8000 + static_cast<std::int64_t>(random() % 4000);
      clock.advance(std::chrono::microseconds(step_us));
      autopilot.advance(clock.now());
      disturb(cable, autopilot, tick, random);
      link.receive(clock.now());
      const safety::AuthorityStage stage = link.authority().stage;
      if (stage == safety::AuthorityStage::kReady || stage == safety::AuthorityStage::kSilent ||
          stage == safety::AuthorityStage::kSilentCold) {
        link.request_control(clock.now());
      }
      (void)link.send(
          GetParam() == Channel::kVirtualRc ? ChannelCommand(vrc::Sticks{}) : ChannelCommand(ctl::Command<double>{}),
          clock.now());
    }
    EXPECT_GT(sent.times.size(), 300U) << "seed " << seed;
    EXPECT_LE(max_in_a_second(sent.times), GetParam() == Channel::kVirtualRc ? 25U : 50U) << "seed " << seed;
  }
}

}  // namespace
}  // namespace m100::link
