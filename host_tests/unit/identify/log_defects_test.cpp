// SPDX-License-Identifier: BSD-3-Clause
// Defects of a log must be reported, and never named as effects of the aircraft.
#include "host_tests/lab/identify/data/log_defects.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <string>

#include "host_tests/lab/identify/axis_pipeline.h"
#include "host_tests/lab/identify/data/ground_time.h"
#include "host_tests/lab/identify/residual_tests/vibration_and_drift.h"
#include "host_tests/property/identify/synthetic_axis.h"
#include "host_tests/unit/identify/one_log.h"

namespace m100::lab::identify {
namespace {

using logs::FlightLog;
using logs::Signal;

IdentifyResult ask(const FlightLog& log) {
  return identify_axis(about(log, "roll", {"second_order", "transport_delay"}));
}

/// A column map with a wrong scale or without the offset of the stick.
std::function<void(FlightLog&)> misread_stick(double factor, double offset) {
  return [=](FlightLog& log) {
    for (double& value : log.of(Signal::kStickRoll)) {
      value = factor * value + offset;
    }
  };
}

struct Case {
  const char* name;
  std::function<void(FlightLog&)> harm;
  const char* verdict;
  const char* must_say;
};

class DamagedLog : public ::testing::TestWithParam<Case> {};

TEST_P(DamagedLog, IsAnsweredHonestly) {
  FlightLog log = healthy_flight("roll", 606);
  ASSERT_EQ(ask(log).verdict, "nothing_missing") << text_of(ask(log));
  GetParam().harm(log);
  const IdentifyResult result = ask(log);
  EXPECT_EQ(result.verdict, GetParam().verdict) << text_of(result);
  EXPECT_NE(text_of(result).find(GetParam().must_say), std::string::npos) << text_of(result);
}

std::vector<double>& roll(FlightLog& log) { return log.of(Signal::kAttitudeRoll); }

INSTANTIATE_TEST_SUITE_P(
    Table, DamagedLog,
    ::testing::Values(
        Case{"SticksInTenThousandths", misread_stick(10000.0 / 660.0, 0.0), "unexplained",
             "wrong_unit: stick_roll reaches"},
        Case{"SticksWithoutTheirOffset", misread_stick(1.0, 1024.0), "unexplained", "wrong_unit: stick_roll reaches"},
        Case{"HeldSamples",
             [](FlightLog& log) {
               for (std::size_t k = 0; k < log.size; ++k) {
                 roll(log)[k] = roll(log)[k / 10 * 10];
               }
             },
             "unexplained", "holds every value for 0.10 s"},
        Case{"Vibration",
             [](FlightLog& log) {
               for (std::size_t k = 0; k < log.size; ++k) {
                 roll(log)[k] += 0.03 * std::sin(2.0 * std::numbers::pi * 33.0 * log.time_s(k));
               }
             },
             "unexplained", "periodic 33.0 Hz"},
        Case{"SensorDrift",
             [](FlightLog& log) {
               for (std::size_t k = 0; k < log.size; ++k) {
                 roll(log)[k] += 0.001 * log.time_s(k);
               }
             },
             "unexplained", "drifts with time"},
        Case{"FrozenSamples",
             [](FlightLog& log) {
               for (std::size_t from = 500; from < 4200; from += 700) {
                 std::fill_n(roll(log).begin() + static_cast<std::ptrdiff_t>(from), 50, roll(log)[from]);
               }
             },
             "unexplained", "frozen: "},
        Case{"Outliers",
             [](FlightLog& log) {
               for (std::size_t k = 400; k < 4300; k += 170) {
                 roll(log)[k] += 0.5;
               }
             },
             "unexplained", "outliers: "},
        Case{"AnotherSignal",
             [](FlightLog& log) {
               const std::vector<double> old = roll(log);
               for (std::size_t k = 0; k < log.size; ++k) {
                 roll(log)[k] = old[(k * 2654435761U) % log.size];
               }
             },
             "unexplained", "hardly follows stick_roll"},
        Case{"LateStick",
             [](FlightLog& log) {
               std::vector<double>& stick = log.of(Signal::kStickRoll);
               std::copy_backward(stick.begin(), stick.end() - 15, stick.end());
             },
             "unexplained", "clock_shift: "},
        Case{"CutStick",
             [](FlightLog& log) {
               for (double& counts : log.of(Signal::kStickRoll)) {
                 counts = std::clamp(counts, -60.0, 60.0);
               }
             },
             "unexplained", "the log may have clipped it there"},
        Case{"ReversedStick",
             [](FlightLog& log) {
               for (double& counts : log.of(Signal::kStickRoll)) {
                 counts = -counts;
               }
             },
             "unexplained", "sign_reversed: "},
        // Catches a simulation that restarts within a gap, and input in a gap that is used although it was not logged.
        Case{"Gaps",
             [](FlightLog& log) {
               for (std::size_t from = 350; from < 4200; from += 310) {
                 for (std::size_t k = from; k < from + 40; ++k) {
                   log.gap[k] = 1;
                   roll(log)[k] = roll(log)[from];
                   log.of(Signal::kStickRoll)[k] = log.of(Signal::kStickRoll)[from];
                 }
               }
             },
             "nothing_missing", ""},
        Case{"GroundBeforeTakeOff",
             [](FlightLog& log) {
               for (std::size_t k = 0; k < 900; ++k) {
                 for (const Signal still : {Signal::kAttitudeRoll, Signal::kAttitudePitch, Signal::kVelocityZ}) {
                   log.of(still)[k] = 0.01;
                 }
                 const double corner = k > 150 && k < 300 ? -330.0 : 0.0;  // motors on
                 for (const Signal stick : {Signal::kStickRoll, Signal::kStickPitch, Signal::kStickThrottle}) {
                   log.of(stick)[k] = corner;
                 }
               }
             },
             "nothing_missing", "on the ground"}),
    [](const auto& tested) { return std::string(tested.param.name); });

TEST(DamagedLogs, DegreesAreReportedAndConverted) {
  FlightLog log = healthy_flight("roll", 606);
  const double gain = ask(log).final_model.parameters[0].value;
  for (double& angle : roll(log)) {
    angle *= 180.0 / std::numbers::pi;
  }
  const IdentifyResult result = ask(log);
  EXPECT_EQ(result.verdict, "unexplained") << text_of(result);
  EXPECT_NE(text_of(result).find("wrong_unit: "), std::string::npos) << text_of(result);
  EXPECT_NEAR(result.final_model.parameters[0].value, gain, 1e-3 * gain);
}

// Sticks logged as commands in radians: time on the ground must be found in them too.
TEST(DamagedLogs, GroundIsKeptOutOfCommandsToo) {
  FlightLog log = healthy_flight("roll", 606);
  for (const auto& [stick, command] :
       {std::pair{Signal::kStickRoll, Signal::kCommandRoll}, std::pair{Signal::kStickPitch, Signal::kCommandPitch},
        std::pair{Signal::kStickThrottle, Signal::kCommandClimb}}) {
    log.of(command) = log.of(stick);
    log.of(stick).clear();
    for (double& value : log.of(command)) {
      value *= 9e-4;
    }
  }
  for (std::size_t k = 0; k < 900; ++k) {
    for (const Signal still : {Signal::kAttitudeRoll, Signal::kAttitudePitch, Signal::kVelocityZ}) {
      log.of(still)[k] = 0.01;
    }
    log.of(Signal::kCommandRoll)[k] = k > 150 && k < 300 ? -0.3 : 0.0;
  }
  EXPECT_NE(text_of(ask(log)).find("on_ground: "), std::string::npos) << text_of(ask(log));
}

// Catches a detector that takes a hover with centred sticks for standing on the ground and removes good data.
TEST(GroundTimes, AFlightThatBeginsInAHoverHasNone) {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    EXPECT_TRUE(ground_times(healthy_flight("roll", seed)).empty()) << "seed " << seed;
  }
}

/// A roll axis as flown; the climb axis hardly moves, and its noise is a tenth of its motion.
FlightLog quiet_climb(std::uint64_t seed) {
  FlightLog log = host_tests::SyntheticAxis::random(seed).fly();
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::vector<double>& climb = log.of(Signal::kVelocityZ);
  double air = 0.0;
  for (std::size_t k = 0; k < log.size; ++k) {
    air += 0.01 * (0.06 * 4.5 * normal(random) - air) / 0.5;
    climb.push_back(0.06 * std::sin(0.9 * log.time_s(k)) + air + 0.01 * normal(random));
  }
  log.of(Signal::kStickThrottle).assign(log.size, 0.0);
  return log;
}

/// The vehicle stands on the ground: the sticks move, and the sensors show only noise.
void stand(FlightLog& log, std::size_t from, std::size_t to) {
  std::mt19937_64 random(from + 17);
  std::normal_distribution<double> normal;
  for (std::size_t k = from; k < to; ++k) {
    roll(log)[k] = 0.004 + 0.002 * normal(random);
    log.of(Signal::kVelocityZ)[k] = 0.01 * normal(random);
  }
}

// Catches a threshold for standing that is below the noise of an axis that hardly moves.
TEST(GroundTimes, AreFoundBesideAnAxisThatHardlyMoves) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    FlightLog log = quiet_climb(seed);
    stand(log, 0, 1000);
    stand(log, 3600, log.size);
    const auto times = ground_times(log);
    ASSERT_EQ(times.size(), 2U) << "seed " << seed;
    // Sticks at rest before the landing or after the take-off lengthen the found time a little.
    EXPECT_NEAR(times[0].second, 10.9, 1.0) << "seed " << seed;
    EXPECT_NEAR(times[1].first, 35.1, 1.0) << "seed " << seed;
    const IdentifyResult result = ask(log);
    EXPECT_TRUE(result.changes.empty()) << text_of(result);
    EXPECT_NE(result.verdict, "explained") << text_of(result);
  }
}

// Catches a landing seen where the stick is held at the end of the log and the roll holds as well.
TEST(GroundTimes, AHeldStickThatIsAnsweredIsNone) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    FlightLog log = quiet_climb(seed);
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    for (std::size_t k = log.size - 300; k < log.size; ++k) {
      log.of(Signal::kStickRoll)[k] = 300.0;
      roll(log)[k] = 0.25 + 0.002 * normal(random);
      log.of(Signal::kVelocityZ)[k] = 0.01 * normal(random);
    }
    EXPECT_TRUE(ground_times(log).empty()) << "seed " << seed;
  }
}

// Pitch still moves, so the vehicle does not stand, but roll no longer responds. That is not a change of the gain.
TEST(GroundTimes, AStickThatIsNoLongerAnsweredHasNoOtherGain) {
  FlightLog log = quiet_climb(3);
  stand(log, 3300, log.size);
  std::vector<double>& pitch = log.of(Signal::kAttitudePitch);
  for (std::size_t k = 0; k < log.size; ++k) {
    pitch.push_back(0.1 * std::sin(1.3 * log.time_s(k)));
  }
  const IdentifyResult result = ask(log);
  EXPECT_TRUE(ground_times(log).empty());
  EXPECT_EQ(result.verdict, "unexplained") << text_of(result);
  EXPECT_TRUE(result.changes.empty()) << text_of(result);
  EXPECT_NE(text_of(result).find("does not answer stick_roll after 3"), std::string::npos) << text_of(result);
}

/// Resamples the log to rows slower than its clock and not in step with it.
void write_slowly(FlightLog& log, double row_s) {
  for (const Signal signal : {Signal::kStickRoll, Signal::kStickPitch, Signal::kAttitudeRoll}) {
    const std::vector<double> fast = log.of(signal);
    const auto at_row = [&](double number) {
      const auto sample = static_cast<std::size_t>(std::lround(number * row_s / log.period_s));
      return fast[std::min(sample, fast.size() - 1)];
    };
    for (std::size_t k = 0; k < log.size; ++k) {
      const double number = static_cast<double>(k) * log.period_s / row_s;
      const double part = number - std::floor(number);
      log.of(signal)[k] = (1.0 - part) * at_row(std::floor(number)) + part * at_row(std::floor(number) + 1.0);
    }
    log.row_s[signal] = row_s;
  }
}

/// At random times sets the stick far off for the length of a row, so that one row is spoilt.
void spoil_the_stick(FlightLog& log, double row_s) {
  std::mt19937_64 random(3);
  for (std::size_t k = 300; k < log.size; k += 120 + random() % 200) {
    for (std::size_t i = k; i < std::min(k + (row_s > 0.02 ? 3U : 1U), log.size); ++i) {
      log.of(Signal::kStickRoll)[i] += k % 2 == 0 ? 400.0 : -300.0;
    }
  }
}

// Catches saturations and curves that are found because a stick was logged with spoilt samples.
TEST(SpoiltStick, IsReportedAndRepaired) {
  for (const double row_s : {0.01, 0.034}) {
    FlightLog log = host_tests::SyntheticAxis::random(12).fly();
    spoil_the_stick(log, row_s);
    if (row_s > 0.02) {
      write_slowly(log, row_s);
    }
    const IdentifyResult result = ask(log);
    EXPECT_EQ(result.verdict, "unexplained") << text_of(result);
    EXPECT_NE(text_of(result).find("outliers: "), std::string::npos) << text_of(result);
    EXPECT_TRUE(result.effects.empty()) << text_of(result);
  }
}

// A hand, the steps of a program and a stick that hardly moves must not be taken for spoilt samples.
TEST(SpoiltStick, IsNotSeenInHealthyOnes) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    for (const double row_s : {0.01, 0.02, 0.034, 0.05, 0.1}) {
      FlightLog log = host_tests::SyntheticAxis::random(seed).fly();
      write_slowly(log, row_s);
      const std::vector<char> used(log.size, 1);
      std::vector<double> hand = log.of(Signal::kStickRoll);
      std::vector<double> steps = hand;
      std::vector<double> rest = hand;
      for (std::size_t k = 0; k < log.size; ++k) {
        steps[k] = std::copysign(200.0, hand[k]);
        rest[k] = std::round(hand[k] / 200.0);
      }
      for (std::vector<double>* stick : {&hand, &steps, &rest}) {
        EXPECT_TRUE(repair_stick(*stick, used, {0.0, log.period_s, row_s}, "stick").empty()) << seed << " " << row_s;
      }
    }
  }
}

// Catches a stick column that freezes while the hand moves on, which was reported as a change of the delay.
TEST(FrozenStick, IsSaidByName) {
  for (std::uint64_t seed = 21; seed <= 24; ++seed) {
    FlightLog log = healthy_flight("roll", seed);
    std::vector<double>& stick = log.of(Signal::kStickRoll);
    for (const std::size_t begin : {700U, 1640U, 3300U}) {
      std::fill_n(&stick[begin], 120, stick[begin]);
    }
    const IdentifyResult result = ask(log);
    EXPECT_EQ(result.verdict, "unexplained") << seed << ": " << text_of(result);
    EXPECT_NE(text_of(result).find("frozen: stick_roll"), std::string::npos) << seed << ": " << text_of(result);
  }
}

// Catches an outlier test that judges the straight lines interpolated between rows.
TEST(SlowRows, OutliersOfOneRowAreFound) {
  for (const double row_s : {0.02, 0.034}) {
    FlightLog log = host_tests::SyntheticAxis::random(5).fly();
    const auto row = static_cast<std::size_t>(std::lround(row_s / log.period_s));
    for (std::size_t k = 400; k < log.size; k += 370) {
      std::for_each_n(roll(log).begin() + static_cast<std::ptrdiff_t>(k), row, [](double& angle) { angle += 0.6; });
    }
    write_slowly(log, row_s);
    const IdentifyResult result = ask(log);
    EXPECT_NE(text_of(result).find("outliers: "), std::string::npos) << text_of(result);
    EXPECT_EQ(text_of(result).find("bursts"), std::string::npos) << text_of(result);
  }
}

TEST(SlowRows, HaveNoLineAboveTheirOwnRate) {
  std::vector<double> residual(4000);
  for (std::size_t k = 0; k < residual.size(); ++k) {
    residual[k] = std::sin(2.0 * std::numbers::pi * 8.2 * 0.01 * static_cast<double>(k));
  }
  EXPECT_GT(vibration_peak(residual, 0.01).share, 0.5);
  EXPECT_EQ(vibration_peak(residual, 0.01, 0.1).share, 0.0);
}

// If the stick moves between two rows, the delay is not known to a fraction of a row, and the report must say so.
TEST(SlowRows, UndersampledSticksAreReported) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    host_tests::SyntheticAxis vehicle = host_tests::SyntheticAxis::random(seed);
    vehicle.air_rad = 0.002;
    FlightLog log = vehicle.fly();
    write_slowly(log, 0.1);
    const IdentifyResult result = ask(log);
    EXPECT_TRUE(result.changes.empty()) << seed << text_of(result);
    EXPECT_NE(text_of(result).find("undersampled"), std::string::npos) << seed << text_of(result);
  }
  FlightLog log = host_tests::SyntheticAxis::random(1).fly();
  EXPECT_EQ(text_of(ask(log)).find("undersampled"), std::string::npos);
}

TEST(VibrationPeak, IsFoundAtItsFrequencyAndNotInNoise) {
  std::vector<double> noise(3000);
  std::uint32_t state = 1;
  for (double& value : noise) {
    state = state * 1664525U + 1013904223U;
    value = static_cast<double>(state >> 8U) / 16777216.0 - 0.5;
  }
  EXPECT_LT(vibration_peak(noise, 0.01).share, 0.1);
  for (std::size_t k = 0; k < noise.size(); ++k) {
    noise[k] += 0.6 * std::sin(2.0 * std::numbers::pi * 21.3 * 0.01 * static_cast<double>(k));
  }
  EXPECT_NEAR(vibration_peak(noise, 0.01).hz, 21.3, 0.2);
  EXPECT_GT(vibration_peak(noise, 0.01).share, 0.5);
}

}  // namespace
}  // namespace m100::lab::identify
