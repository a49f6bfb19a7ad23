// SPDX-License-Identifier: BSD-3-Clause
// Streams of set points with the whole flight controller: how closely they are flown, and that they stay inside.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <vector>

#include "firmware/companion/ground_station/ground_station_commands.h"
#include "hal/mock/manual_clock.h"
#include "hal/mock/uart_pair.h"
#include "host_tests/scenario/faults/fault_bench.h"
#include "host_tests/scenario/faults/message_recorder.h"
#include "host_tests/sim/world/random.h"

namespace m100::scenario {
namespace {

using Vector = core::Vector<double, 3>;

constexpr mavlink::Address kPlanner{.system = 1, .component = 240};
constexpr std::uint16_t kWithoutYawRate = 1U << 11U;

/// A motion relative to the start, in the flight's world.
struct Motion {
  Vector position_m, velocity_m_s, acceleration_m_s2;
};

/// What is flown, beside what was demanded, tick by tick.
struct Trace {
  std::vector<double> time_s;
  std::vector<Vector> flown;
};

class StreamTest : public ::testing::Test {
 protected:
  void begin(const core::Fence& fence, const sim::Plant& plant, const companion::StreamLimits& limits) {
    bench_.emplace(link::Channel::kVirtualRc, 0, fence, plant);
    commands_.emplace(companion::GoalSettings{.limits = {}, .stream = limits}, fence, bench_->course(), line_, nullptr,
                      heard_);
    ASSERT_TRUE(bench_->take_off());
    start_ = bench_->place();
    begin_ = bench_->world().now();
  }
  double time_s() { return core::seconds<double>(bench_->world().now() - begin_); }
  const Vector& at() { return bench_->world().vehicle().state().position_w_m; }
  template <typename Message>
  void send(const Message& message, mavlink::Address from = kPlanner) {
    const mavlink::Frame frame = mavlink::encode(message, from, sequence_++);
    EXPECT_EQ(pair_.b().write(frame.bytes()).value_or(0), frame.bytes().size());
    std::vector<std::byte> got(frame.bytes().size());
    EXPECT_EQ(line_.read(got).value_or(0), got.size());
  }
  mavlink::SetPositionTargetLocalNed set_point(const Motion& motion, double stamp_s, std::uint16_t mask) const {
    const Vector place = start_ + motion.position_m;
    const auto ned = [](const Vector& v, int axis) { return static_cast<float>(axis == 0 ? v[axis] : -v[axis]); };
    return {.time_boot_ms = static_cast<std::uint32_t>(std::llround(1000.0 * stamp_s) + 4'000'000'000),
            .x = ned(place, 0),
            .y = ned(place, 1),
            .z = ned(place, 2),
            .vx = ned(motion.velocity_m_s, 0),
            .vy = ned(motion.velocity_m_s, 1),
            .vz = ned(motion.velocity_m_s, 2),
            .afx = ned(motion.acceleration_m_s2, 0),
            .afy = ned(motion.acceleration_m_s2, 1),
            .afz = ned(motion.acceleration_m_s2, 2),
            .type_mask = mask,
            .target_system = 1,
            .coordinate_frame = 1};
  }
  void tick() {
    bench_->tick();
    const core::TimePoint now = bench_->world().now();
    (void)commands_->tick(now, bench_->controller(), {});
  }
  /// Streams a motion for a time: `rate_hz` set points a second, each late by up to the jitter.
  template <typename Demand>
  Trace fly(const Demand& demand, double duration_s, double rate_hz, double jitter_s, std::uint16_t mask) {
    sim::Random random(7, "jitter");
    Trace trace;
    std::vector<std::pair<double, double>> on_the_way;  // arrival, stamp
    for (double next_s = time_s(), end_s = next_s + duration_s, from_s = next_s; time_s() < end_s;) {
      if (time_s() >= next_s) {
        on_the_way.emplace_back(next_s + jitter_s * random.uniform(), next_s);
        next_s += 1.0 / rate_hz;
      }
      while (!on_the_way.empty() && on_the_way.front().first <= time_s()) {
        const double stamp_s = on_the_way.front().second;
        on_the_way.erase(on_the_way.begin());
        send(set_point(demand(stamp_s - from_s), stamp_s, mask));
      }
      tick();
      trace.time_s.push_back(time_s() - from_s);
      trace.flown.push_back(at() - start_);
    }
    return trace;
  }

  std::optional<FaultBench> bench_;
  MessageRecorder heard_;
  hal::ManualClock clock_;
  hal::UartPair pair_{clock_, 0};
  companion::GroundStationTap line_{pair_.a()};
  std::optional<companion::GroundStationCommands> commands_;
  Vector start_ = Vector::Zero();
  core::TimePoint begin_{};
  std::uint8_t sequence_ = 0;
};

struct Error {
  double rms_m = 1e9;
  double delay_s = 0.0;
};

/// The root mean square distance from the demanded motion, delayed by the constant that makes it smallest.
template <typename Demand>
Error error_of(const Trace& trace, const Demand& demand, double largest_delay_s) {
  Error best;
  for (double delay_s = 0.0; delay_s <= largest_delay_s; delay_s += 0.01) {
    double sum = 0.0;
    for (std::size_t i = 0; i < trace.time_s.size(); ++i) {
      sum += (trace.flown[i] - demand(trace.time_s[i] - delay_s).position_m).squaredNorm();
    }
    const double rms_m = std::sqrt(sum / static_cast<double>(trace.time_s.size()));
    best = rms_m < best.rms_m ? Error{rms_m, delay_s} : best;
  }
  return best;
}

/// The paper's square (IV-C.4): 1 m in 2.5 s, at rest in each corner for 0.5 s; `rounds` times.
struct Square {
  explicit Square(int rounds) {
    course.hold({});
    for (int round = 0; round < rounds; ++round) {
      EXPECT_EQ(course.append_square(1.0, milliseconds(2500), milliseconds(500)), core::Status::kOk);
    }
  }
  Motion operator()(double t_s) const {
    const ref::Motion motion = course.motion(core::Duration(std::llround(1e6 * std::max(t_s, 0.0))));
    const auto order = [&](std::size_t n) { return Vector(motion[0][n], motion[1][n], motion[2][n]); };
    return {order(0), order(1), order(2)};
  }
  ref::Trajectory<double> course;
};

core::Fence room() { return {.side = {{{-5.0, 5.0}, {-5.0, 5.0}, {0.5, 4.0}}}, .wind_m_s = 5.0}; }

TEST_F(StreamTest, TheSquareIsFlownAlmostAsFromACourseFile) {
  const auto square = std::make_unique<Square>(3);
  const double length_s = core::seconds<double>(square->course.duration());
  begin(room(), sim::measured_plant(), {});
  ref::Trajectory<double>& course = bench_->course();
  course.hold({.position_w_m = start_});
  for (int round = 0; round < 3; ++round) {
    ASSERT_EQ(course.append_square(1.0, milliseconds(2500), milliseconds(500)), core::Status::kOk);
  }
  course.start(bench_->world().now());
  Trace by_file;
  for (const double from_s = time_s(); time_s() - from_s < length_s;) {
    tick();
    by_file.time_s.push_back(time_s() - from_s);
    by_file.flown.push_back(at() - start_);
  }
  const Error file = error_of(by_file, *square, 0.3);
  for (const auto& [name, mask] : {std::pair{"position, velocity, acceleration", kWithoutYawRate},
                                   {"position, velocity", std::uint16_t{kWithoutYawRate | 0b111000000}},
                                   {"position", std::uint16_t{kWithoutYawRate | 0b111111000}}}) {
    begin(room(), sim::measured_plant(), {});
    const Error stream = error_of(fly(*square, length_s, 20.0, 0.03, mask), *square, 1.0);
    std::printf("%s: %.4f m rms, %.2f s late; from the file %.4f m, %.2f s\n", name, stream.rms_m, stream.delay_s,
                file.rms_m, file.delay_s);
    RecordProperty("delay_s", std::to_string(stream.delay_s));
    if (mask == kWithoutYawRate) {
      EXPECT_LE(stream.rms_m, 1.5 * file.rms_m);
    }
    EXPECT_EQ(bench_->failsafe_state(), FailsafeState::kNominal) << heard_.all();
  }
}

// A figure of eight, 2 m/s at its crossing.
TEST_F(StreamTest, AFigureOfEightOfTwoMetresASecondStaysInsideInWind) {
  constexpr double kHalf_m = 2.0, kSpeed_m_s = 2.0;
  const double w = kSpeed_m_s / (kHalf_m * std::numbers::sqrt2);
  const auto eight = [&](double t_s) {
    const double t = std::max(t_s, 0.0);
    const double s = w * std::min(t, 1.0) * std::min(t, 1.0) / 2.0 + w * std::max(t - 1.0, 0.0);  // from rest
    const double ds = w * std::min(t, 1.0), dds = t < 1.0 ? w : 0.0;
    const auto axis = [&](double size, double times) {
      return std::array{size * std::sin(times * s), size * times * ds * std::cos(times * s),
                        size * times * (dds * std::cos(times * s) - times * ds * ds * std::sin(times * s))};
    };
    const auto x = axis(kHalf_m, 1.0), y = axis(kHalf_m / 2.0, 2.0);
    return Motion{{x[0], y[0], 0.0}, {x[1], y[1], 0.0}, {x[2], y[2], 0.0}};
  };
  sim::Plant plant = sim::measured_plant();
  // The pilot of this bench does not hold the aircraft against a wind, so it begins in flight.
  plant.air.linear_drag_per_s = 0.3;
  constexpr double kWindBegins_s = 20.0;
  plant.change = {.at_s = kWindBegins_s, .steps = {[](sim::Plant& changed) {
                                           changed.air.wind_m_s = {3.5, -3.5, 0.0};
                                           changed.air.gust_m_s = 1.5;
                                         }}};
  core::Fence fence = room();
  fence.side[0] = {-2.5, 2.5};
  fence.side[1] = {-1.6, 1.6};
  begin(fence, plant, {.speed_m_s = 2.5, .acceleration_m_s2 = 4.0});
  ASSERT_LT(core::seconds<double>(bench_->world().now().time_since_epoch()), kWindBegins_s);
  const Trace trace = fly(eight, 40.0, 20.0, 0.03, kWithoutYawRate);
  const Error error = error_of(trace, eight, 1.0);
  std::printf("figure of eight: %.3f m rms, %.2f s late\n", error.rms_m, error.delay_s);
  EXPECT_EQ(bench_->failsafe_state(), FailsafeState::kNominal) << heard_.all();
  for (std::size_t i = 0; i < trace.flown.size(); ++i) {
    const Vector place = start_ + trace.flown[i];
    for (int axis = 0; axis < 3; ++axis) {
      const core::Fence::Side& side = fence.side[static_cast<std::size_t>(axis)];
      ASSERT_GE(place[axis], side.low_m) << "after " << trace.time_s[i] << " s, axis " << axis;
      ASSERT_LE(place[axis], side.high_m) << "after " << trace.time_s[i] << " s, axis " << axis;
    }
  }
  EXPECT_LT(error.rms_m, 0.3) << "it must be flown, not only kept inside";
}

struct StreamAnswers : StreamTest {
  static constexpr std::uint16_t kVelocityOnly = 1479, kPlaceOnly = 0b110111111000;
  void SetUp() override { begin(room(), sim::measured_plant(), {}); }
  void pass(double seconds_s) {
    for (const double end_s = time_s() + seconds_s; time_s() < end_s;) {
      tick();
    }
  }
  static Motion moving(double x_m, double vx_m_s) { return {{x_m, 0.0, 0.0}, {vx_m_s, 0.0, 0.0}, Vector::Zero()}; }
  double speed() { return bench_->world().vehicle().state().velocity_w_m_s.norm(); }
};

TEST_F(StreamAnswers, AVelocityIsFlownInsideTheFenceAndItsEndBrakesAndHolds) {
  send(set_point(moving(0.0, 1.0), time_s(), kVelocityOnly));
  pass(1.0);
  EXPECT_LT(speed(), 0.1) << "one motion alone begins nothing";
  (void)fly([](double) { return moving(0.0, 1.0); }, 2.0, 10.0, 0.03, kVelocityOnly);
  EXPECT_NEAR(speed(), 1.0, 0.15) << heard_.all();
  pass(3.0);
  EXPECT_TRUE(heard_.has("has ended: it brakes and holds")) << heard_.all();
  EXPECT_LT(speed(), 0.1);
  EXPECT_LT((at() - start_).x(), 3.2);
  const Trace trace = fly([](double) { return moving(0.0, 1.4); }, 8.0, 10.0, 0.03, kVelocityOnly);
  for (const Vector& place : trace.flown) {
    ASSERT_LT((start_ + place).x(), room().side[0].high_m);
  }
  EXPECT_GT((at() - start_).x(), 4.0) << "it must be flown to the side";
  EXPECT_TRUE(heard_.has("beyond the fence")) << heard_.all();
  EXPECT_EQ(bench_->failsafe_state(), FailsafeState::kNominal) << heard_.all();
}

TEST_F(StreamAnswers, AFarPlaceIsFlownToFirstAndARepeatedOneStaysAGoal) {
  const auto far = [](double t_s) { return moving(3.0 + 0.2 * t_s, 0.2); };
  (void)fly(far, 7.0, 20.0, 0.0, kWithoutYawRate);
  EXPECT_TRUE(heard_.has("it flies there first")) << heard_.all();
  EXPECT_NEAR((at() - start_).x(), far(7.0 - 0.3).position_m.x(), 0.15) << heard_.all();
  pass(3.0);
  heard_ = {};
  (void)fly([](double) { return moving(0.0, 0.0); }, 8.0, 20.0, 0.0, kPlaceOnly);
  EXPECT_FALSE(heard_.has("stream")) << heard_.all();
  EXPECT_LT((at() - start_).norm(), 0.2);
}

// Each is refused by name, and the stream goes on.
TEST_F(StreamAnswers, WhatDoesNotBelongToTheStreamIsRefusedByName) {
  const auto still = [&](double t_s) {
    const Motion motion = moving(0.1 * t_s, 0.1);
    if (t_s < 0.3) {
      return motion;
    }
    auto wrong = set_point(moving(-2.0, 0.0), time_s(), kWithoutYawRate);
    switch (static_cast<int>(20.0 * t_s) % 5) {
      case 0:
        send(wrong, {.system = 255, .component = 190});
        break;
      case 1:
        wrong.type_mask = kPlaceOnly;
        send(wrong);
        break;
      case 2:
        wrong.vy = std::numeric_limits<float>::quiet_NaN();
        send(wrong);
        break;
      case 3:
        wrong.yaw = 90.F;
        send(wrong);
        break;
      default:
        break;
    }
    tick();  // each in a tick of its own
    return motion;
  };
  (void)fly(still, 4.0, 20.0, 0.0, kWithoutYawRate);
  EXPECT_NEAR((at() - start_).x(), 0.37, 0.1) << heard_.all();
  for (const char* const reason :
       {"another sender lead", "masks of a stream must not change", "not finite", "degrees"}) {
    EXPECT_TRUE(heard_.has(reason)) << reason << heard_.all();
  }
  pass(3.0);
  // Two velocities, an acceleration alone, a force, two coordinates beside a velocity.
  constexpr std::array<std::uint16_t, 4> kPartial{0b110111010111, 0b110000111111, 0b111111000111, 0b110111000001};
  for (const std::uint16_t mask : kPartial) {
    auto other = set_point(moving(0.0, 0.0), time_s(), kPlaceOnly);
    other.coordinate_frame = 8;  // another refusal between: a repeated one gives one line
    send(other);
    pass(1.1);
    heard_ = {};
    send(set_point(moving(0.0, 1.0), time_s(), mask));
    pass(0.5);
    EXPECT_TRUE(heard_.has("refused: a mask must name")) << mask << heard_.all();
  }
  EXPECT_LT(speed(), 0.1);
}

TEST_F(StreamAnswers, TooFastIsCutAndNamedAndAnOrderToHoldStopsTheStream) {
  (void)fly([](double) { return moving(0.0, 3.0); }, 1.5, 20.0, 0.0, kVelocityOnly);
  EXPECT_TRUE(heard_.has("the speed is cut to its limit")) << heard_.all();
  EXPECT_LT(speed(), 1.65);
  const double here_m = (at() - start_).x();
  send(mavlink::CommandLong{.param1 = 0.F, .command = companion::kPauseContinue, .target_system = 1});
  (void)fly([](double) { return moving(0.0, 1.0); }, 4.0, 20.0, 0.0, kVelocityOnly);
  EXPECT_LT(speed(), 0.1) << heard_.all();
  EXPECT_LT((at() - start_).x(), here_m + 2.0);
  EXPECT_TRUE(heard_.has("an order to hold stopped this stream")) << heard_.all();
}

}  // namespace
}  // namespace m100::scenario
