// SPDX-License-Identifier: BSD-3-Clause
// What a model leaves, drawn against channels: the channel that acts stands first, and a channel that does not predicts
// nothing.
#include "host_tests/lab/identify/remainder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace m100::lab::identify {
namespace {

constexpr double kRow_s = 0.05;
constexpr std::size_t kRows = 1600;  // 80 s
constexpr double kLag_s = 0.2;       // of a first-order model

std::vector<double> wandering(double time_s, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const double keep = std::exp(-kRow_s / time_s);
  std::vector<double> out(kRows, normal(random));
  for (std::size_t i = 1; i < kRows; ++i) {
    out[i] = keep * out[i - 1] + std::sqrt(1.0 - keep * keep) * normal(random);
  }
  return out;
}

/// What a first-order lag makes of a command that is held between rows.
std::vector<double> lagged(const std::vector<double>& command) {
  std::vector<double> out(command.size(), command.front());
  for (std::size_t i = 1; i < command.size(); ++i) {
    out[i] = command[i - 1] + std::exp(-kRow_s / kLag_s) * (out[i - 1] - command[i - 1]);
  }
  return out;
}

/// A log with the extra channels "cause" and "other", and a model that lacks `added` of the cause and the command.
struct Flight {
  template <typename Added>
  explicit Flight(Added added, double air_rms = 0.3) {
    log.period_s = kRow_s;
    log.size = kRows;
    log.extra["cause"] = wandering(3.0, 1);
    log.extra["other"] = wandering(3.0, 2);
    const std::vector<double> command = wandering(0.8, 3);
    const std::vector<double> air = wandering(0.3, 4);
    std::vector<double> missing(kRows);
    for (std::size_t i = 0; i < kRows; ++i) {
      missing[i] = added(log.extra["cause"][i], command[i]) + air_rms * air[i];
      input.t_s.push_back(log.time_s(i));
    }
    input.row_s = kRow_s;
    input.slope_s = kLag_s;
    input.error = lagged(missing);
    input.model = lagged(command);
  }

  logs::FlightLog log;
  RemainderInput input;
};

std::vector<RemainderCurve> curves_of(const Flight& flight) { return remainder_curves({flight.input}, flight.log); }

// Catches a remainder without the inverse dynamics, and a curve whose size or whose form is wrong.
TEST(Remainder, ShowsWhatIsAdded) {
  const std::vector<RemainderCurve> curves =
      curves_of(Flight([](double cause, double) { return 0.5 * cause * cause; }));
  const RemainderCurve& first = curves.front();
  EXPECT_EQ(first.channel, "cause");
  EXPECT_FALSE(first.is_gain);
  EXPECT_GT(first.predicted, 0.5);
  for (const RemainderCurve& curve : curves) {
    EXPECT_TRUE(curve.channel == "cause" || curve.predicted < first.chance) << curve.channel;
    EXPECT_LT(curve.after_first, 0.05) << curve.channel;
  }
  ASSERT_EQ(first.x.size(), 41U);
  const double rise = first.value.back() - first.value[20];
  const double expected = 0.5 * (first.x.back() * first.x.back() - first.x[20] * first.x[20]);
  EXPECT_NEAR(rise, expected, 0.2 * expected);
}

// Catches a form that is mistaken for the other: the mean of a changed gain over a symmetric command is zero.
TEST(Remainder, ShowsAGainThatChanges) {
  const std::vector<RemainderCurve> curves =
      curves_of(Flight([](double cause, double command) { return 0.4 * cause * command; }, 0.2));
  EXPECT_EQ(curves.front().channel, "cause");
  EXPECT_TRUE(curves.front().is_gain);
  const RemainderCurve& first = curves.front();
  EXPECT_NEAR(first.value.back() - first.value.front(), 0.4 * (first.x.back() - first.x.front()), 0.16);
}

// Catches a share on the data of the fit itself, in which every channel predicts something, and a band of white noise.
TEST(Remainder, AirAloneIsNotPredicted) {
  const std::vector<RemainderCurve> curves = curves_of(Flight([](double, double) { return 0.0; }));
  ASSERT_EQ(curves.size(), 6U) << "time, cause, other; both forms";
  EXPECT_LT(curves.front().predicted, 0.05);
  for (const RemainderCurve& curve : curves) {
    std::size_t outside = 0;
    for (std::size_t k = 0; k < curve.x.size(); ++k) {
      outside += curve.low[k] > 0.0 || curve.high[k] < 0.0 ? 1U : 0U;
    }
    EXPECT_LT(outside, curve.x.size() / 2) << curve.channel;
  }
}

TEST(Remainder, NeedsTenSeconds) {
  Flight flight([](double cause, double) { return cause; });
  for (std::vector<double>* one : {&flight.input.t_s, &flight.input.error, &flight.input.model}) {
    one->resize(150);  // 7.5 s
  }
  EXPECT_TRUE(curves_of(flight).empty());
}

}  // namespace
}  // namespace m100::lab::identify
