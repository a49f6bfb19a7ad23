// SPDX-License-Identifier: BSD-3-Clause
// What the loop declares, and which decisions its trial flights may take.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <sstream>

#include "firmware/companion/files/text/json.h"
#include "firmware/model/stick_axis.h"
#include "firmware/mpc/generated/gain_table.h"
#include "firmware/sysid/axis_dynamics.h"
#include "host_tests/lab/experiments/tasks.h"
#include "host_tests/lab/logs/alignment/capture_alignment.h"
#include "host_tests/lab/loop/close_loop.h"
#include "host_tests/lab/loop/log_folder.h"
#include "host_tests/lab/loop/ordered_margin.h"
#include "host_tests/lab/loop/page.h"
#include "host_tests/lab/loop/paired_flights.h"
#include "host_tests/lab/loop/results.h"
#include "host_tests/lab/loop/trial_flights.h"
#include "host_tests/lab/loop/vehicle_comparison.h"
#include "host_tests/sim/world/random.h"

namespace m100::lab::loop {
namespace {

using Cells = std::vector<experiments::TaskResult>;
using Channels = std::set<std::string>;

/// Results of the trajectory in calm air and in wind.
Cells cells(double calm_m, double wind_m) {
  Cells out(2);
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[i].task = &experiments::paper_tasks().at(i);
    out[i].seeds = 5;
    out[i].mean.pose_m = i == 0 ? calm_m : wind_m;
    out[i].flights.assign(5, {.pose_m = out[i].mean.pose_m, .x_m = out[i].mean.pose_m});
  }
  return out;
}

TEST(Declared, IsAllThatTheVehicleFileSays) {
  model::Vehicle vehicle = mpc::generated::kVehicle;
  using Names = std::vector<std::string>;
  EXPECT_EQ(declared(vehicle, "roll"), (Names{"second_order", "lead_zero", "dead_zone"}));
  EXPECT_EQ(declared(vehicle, "climb"), (Names{"second_order", "gain_asymmetry", "stick_curve"}));
  EXPECT_EQ(declared(vehicle, "yaw_rate"), (Names{"first_order", "stick_curve"}));
  EXPECT_EQ(declared(vehicle, "translation"), (Names{"rigid_body", "linear_drag"}));
  vehicle.roll.lead_zero_s = 0.0;
  vehicle.roll.saturation = 0.5;
  vehicle.roll.rate_limit_per_s = 2.0;
  vehicle.roll.backlash_counts = 5.0;
  vehicle.roll.gain_drift_per_minute = 0.1;
  vehicle.roll.cross_axis = 0.1;
  EXPECT_EQ(declared(vehicle, "roll"), (Names{"second_order", "transport_delay", "dead_zone", "saturation",
                                              "rate_limit", "backlash", "gain_drift", "cross_axis"}));
}

/// A minute of turns: the attitude shows them at once, the capture is late, with noise of 5 mrad and a drifting
/// heading.
logs::FlightLog turning(double lag_s, double rate_rad_s, std::vector<double>& captured_rad) {
  logs::FlightLog log;
  log.size = 6000;
  const auto heading = [&](double t_s) { return 3.0 + rate_rad_s / 0.7 * std::sin(0.7 * t_s); };  // crosses half a turn
  sim::Random random(3, "captured");
  for (std::size_t k = 0; k < log.size; ++k) {
    const double t_s = log.time_s(k);
    log.of(logs::Signal::kAttitudeYaw).push_back(heading(t_s));
    captured_rad.push_back(
        std::remainder(heading(t_s - lag_s) + 2e-3 * t_s + 5e-3 * random.normal(), 2.0 * std::numbers::pi));
  }
  return log;
}

// Once the observer's estimate of the pose age was 20 ms wrong, and a climb that was seen too early was called
// backlash.
TEST(Captured, LagIsReadOffTheHeading) {
  for (const double lag_s : {-0.012, 0.0, 0.0235, 0.06}) {
    std::vector<double> captured_rad;
    const logs::FlightLog log = turning(lag_s, 0.4, captured_rad);
    EXPECT_NEAR(logs::capture_lag_s(log, captured_rad, {2.0, 58.0}, 1.0), lag_s, 1e-3);
  }
}

TEST(Captured, AHeadingThatHardlyTurnsTellsNothing) {
  std::vector<double> captured_rad;
  const logs::FlightLog log = turning(0.02, 0.01, captured_rad);
  EXPECT_EQ(logs::capture_lag_s(log, captured_rad, {2.0, 58.0}, 0.017), 0.017);
  EXPECT_EQ(logs::capture_lag_s(log, {}, {2.0, 58.0}, 0.017), 0.017);
}

// A source that is only listened to is late by a constant that nobody knows.
TEST(Captured, PositionIsMovedByTheLagOfItsHeading) {
  std::vector<double> captured_rad;
  logs::FlightLog log = turning(0.0235, 0.4, captured_rad);
  for (std::size_t k = 0; k < log.size; ++k) {
    for (int c = 0; c < 3; ++c) {
      log.of(logs::offset(logs::Signal::kPositionX, c)).push_back(std::sin(log.time_s(k) - 0.0235));
      log.of(logs::offset(logs::Signal::kVelocityX, c)).push_back(0.0);
    }
  }
  const logs::FlightLog without = logs::with_aligned_position(log);
  EXPECT_EQ(without.of(logs::Signal::kPositionX), log.of(logs::Signal::kPositionX));
  EXPECT_TRUE(without.notes.empty());
  log.extra["pose_yaw"] = captured_rad;
  const logs::FlightLog aligned = logs::with_aligned_position(log);
  EXPECT_NEAR(aligned.of(logs::Signal::kPositionX)[3000], std::sin(log.time_s(3000)), 1e-3);
  EXPECT_FALSE(aligned.has(logs::Signal::kVelocityX));
  log.extra["pose_yaw"].assign(log.size, 0.0);
  log.of(logs::Signal::kAttitudeYaw).assign(log.size, 0.0);
  const logs::FlightLog still = logs::with_aligned_position(log);
  EXPECT_EQ(still.of(logs::Signal::kPositionX), log.of(logs::Signal::kPositionX));
  EXPECT_NE(still.notes.at(0).find("unknown"), std::string::npos);
}

// A log may show a lead zero that cancels a pole; the loop must continue without it.
TEST(Uncontrollable, IsALeadZeroThatCancelsAPole) {
  model::Vehicle vehicle = mpc::generated::kVehicle;
  EXPECT_EQ(uncontrollable(vehicle), "");
  vehicle.design = {};  // the law takes the axis itself
  vehicle.roll.damping_ratio = 1.0;
  vehicle.roll.natural_frequency_rad_s = 8.0;
  vehicle.roll.lead_zero_s = 1.0 / 8.0;
  EXPECT_NE(uncontrollable(vehicle).find("cancels a pole"), std::string::npos) << uncontrollable(vehicle);
}

// Catches fixed file names, with which two concurrent loops read each other's logs, and logs that are left behind.
TEST(LogFolder, IsOfOneLoopAloneAndGoesWithIt) {
  namespace fs = std::filesystem;
  std::string first, second;
  {
    const LogFolder one(""), other("");
    first = one.file("train.ulg");
    second = other.file("train.ulg");
    std::ofstream(first) << "one";
    std::ofstream(second) << "other";
    EXPECT_NE(first, second);
    EXPECT_TRUE(fs::exists(first) && fs::exists(second)) << first << " " << second;
  }
  for (const std::string& file : {first, second}) {
    EXPECT_FALSE(fs::exists(fs::path(file).parent_path())) << file;
  }
  const std::string kept = ::testing::TempDir();
  EXPECT_EQ(fs::path(LogFolder(kept).file("train.ulg")), fs::path(kept) / "train.ulg");
  EXPECT_TRUE(fs::exists(kept)) << "what the caller named stays";
}

TEST(Trial, KeepsWhatIsBetter) {
  const Trial trial = fly_trials({"climb", "roll"}, cells(0.2, 0.3), [](const Channels&) { return cells(0.1, 0.2); });
  EXPECT_EQ(trial.kept, (Channels{"climb", "roll"}));
}

// Once one wind cell ended 499 m away, and three good axes were rejected.
TEST(Trial, ACellThatDivergesBeforeAndAfterVetoesNothing) {
  const Trial trial =
      fly_trials({"climb", "pitch", "roll"}, cells(0.2, 450.0), [](const Channels&) { return cells(0.1, 499.0); });
  EXPECT_EQ(trial.kept.size(), 3U);
  ASSERT_FALSE(trial.messages.empty());
  EXPECT_NE(trial.messages.front().find("diverged"), std::string::npos) << trial.messages.front();
}

TEST(Trial, InWhichAllDivergesHasNoErrorInsteadOfNone) {
  const Trial trial = fly_trials({"roll"}, cells(400.0, 450.0), [](const Channels&) { return cells(410.0, 499.0); });
  ASSERT_FALSE(trial.messages.empty());
  EXPECT_EQ(trial.messages.back(), "trial flights: no task was flown to its end both before and after");
}

TEST(Trial, TakesBackTheOneChannelThatMakesACellDiverge) {
  const Trial trial = fly_trials({"climb", "pitch", "roll"}, cells(0.2, 0.3), [](const Channels& channels) {
    return channels.count("pitch") > 0 ? cells(0.1, 499.0)
                                       : cells(0.25 - 0.05 * static_cast<double>(channels.size()), 0.2);
  });
  EXPECT_EQ(trial.kept, (Channels{"climb", "roll"}));
}

TEST(Trial, WithNothingThatIsBetterKeepsNothing) {
  const Trial trial = fly_trials({"climb", "roll"}, cells(0.2, 0.3), [](const Channels&) { return cells(0.3, 0.4); });
  EXPECT_TRUE(trial.kept.empty());
}

// Catches a rule that favours one side: +5.8 mm [+5.1, +6.5] was "no difference", because worse began at 1.1 and better
// at 1; 0.0148 -> 0.0148 m was "worse"; four pairs were "worse", too.
TEST(PairedFlights, AreJudgedByOneSymmetricalRule) {
  const auto judged = [](double by, double apart, std::size_t pairs = kMinPairs) {
    const std::vector<double> before{0.010, 0.012, 0.011, 0.013, 0.009, 0.011};
    std::vector<double> after;
    for (std::size_t i = 0; i < pairs; ++i) {
      after.push_back(before[i] + by + (i % 2 == 0 ? apart : -apart));
    }
    return std::string(compare_pairs({before.begin(), before.begin() + std::ptrdiff_t(pairs)}, after).verdict());
  };
  for (const auto& [sign, words] : {std::pair{1.0, "worse"}, {-1.0, "better"}}) {
    EXPECT_EQ(judged(sign * 0.0010, 1e-4), words);
    EXPECT_EQ(judged(sign * 0.0006, 2e-4), words) << "the interval reaches into +-5 %";
    EXPECT_EQ(judged(sign * 0.0003, 1e-4), "no difference") << "certain, but below 5 % of 11 mm";
    EXPECT_EQ(judged(sign * 0.0010, 2e-3), "cannot tell");
    EXPECT_EQ(judged(sign * 0.0010, 1e-4, kMinPairs - 1), "cannot tell");
    EXPECT_EQ(judged(sign * 0.0010, 1e-4, 1), "cannot tell");
  }
  EXPECT_EQ(judged(0.0, 0.0), "no difference");
  EXPECT_EQ(judged(0.0, 2e-3), "cannot tell") << "a wide interval round zero is not the absence of a difference";
  // Flights of 0.3 to 12 m before, 8 mm after, were "no difference": the first flights differ among themselves.
  EXPECT_STREQ(compare_pairs({0.3, 12.0, 0.5, 7.0, 0.9}, {0.008, 0.009, 0.008, 0.008, 0.009}).verdict(), "cannot tell");
}

TEST(PairedFlights, QuoteTheNumbersOfTheRule) {
  const PairedErrors four = compare_pairs({0.1, 0.1, 0.1, 0.1}, {0.2, 0.2, 0.2, 0.2});
  EXPECT_EQ(describe(four), "0.1000 -> 0.2000 m, +0.1000 [+0.1000, +0.1000]: cannot tell (4 pairs)");
  EXPECT_NE(paired_rule().find("fewer than " + std::to_string(kMinPairs) + " pairs"), std::string::npos);
  EXPECT_NE(paired_rule().find("+-5 % of before"), std::string::npos);
}

TEST(PairedFlights, KeepHorizontalAndVerticalErrorApart) {
  Cells before = cells(0.1, 0.1), after = cells(0.2, 0.2);
  for (Cells* side : {&before, &after}) {
    for (experiments::TaskResult& cell : *side) {
      cell.flights.assign(5, {.pose_m = 1.0, .x_m = side == &before ? 0.1 : 0.2, .z_m = 0.99});
    }
  }
  const PairedTask task = compare_tasks(before, after).begin()->second;
  EXPECT_STREQ(task.pose.verdict(), "no difference");
  EXPECT_STREQ(task.horizontal.verdict(), "worse");
  EXPECT_STREQ(task.vertical.verdict(), "no difference");
  EXPECT_TRUE(task.is_worse());
}

// A model with 70 ms too little delay gave a law with a peak sensitivity of 2.5 on the aircraft. It hovered better than
// the corrected law for this alone.
TEST(OrderedMargin, SlowsDownALawWhoseModelHasTooShortADelay) {
  const model::Vehicle believed = mpc::generated::kVehicle;
  model::Vehicle truth = believed;
  truth.roll.transport_delay_s = truth.pitch.transport_delay_s += 0.07;
  const MarginOrder order = order_of(believed);
  EXPECT_FALSE(keeps_ordered_margin(believed, truth, order));
  const OrderedLaw slower = at_ordered_margin(believed, truth, order);
  EXPECT_GT(model::flown_weights(slower.vehicle).input, model::flown_weights(believed).input);
  EXPECT_EQ(slower.keeps, keeps_ordered_margin(slower.vehicle, truth, order));
  EXPECT_EQ(model::flown_weights(at_ordered_margin(believed, believed, order).vehicle).input,
            model::flown_weights(believed).input);
}

TEST(TrajectoryErrors, LeaveOutACellThatDivergesAndNameIt) {
  LoopResult result;
  result.before.experiments = cells(0.2, 0.3);
  result.after.experiments = cells(0.1, 499.0);
  for (Cells* side : {&result.before.experiments, &result.after.experiments}) {
    for (experiments::TaskResult& cell : *side) {
      static experiments::Task trajectory = experiments::paper_tasks().front();
      trajectory.task = "trajectory";
      cell.task = &trajectory;
    }
  }
  const TrajectoryErrors errors = trajectory_errors(result);
  EXPECT_EQ(errors.before_m, 0.2);
  EXPECT_EQ(errors.after_m, 0.1);
  ASSERT_EQ(errors.diverged.size(), 1U);
}

std::string page_of(const LoopResult& result) {
  const std::string file = (std::filesystem::path(::testing::TempDir()) / "m100_loop_page.html").string();
  write_page(result, file);
  std::stringstream page;
  page << std::ifstream(file).rdbuf();
  std::filesystem::remove(file);
  return page.str();
}

// Catches a page whose box or table says "worse" because a mean grew by 3 %, where the pairs cannot tell, and one that
// says a verdict without its rule.
TEST(Page, SaysWorseOnlyWhereThePairsDo) {
  for (const double by : {1.03, 1.5}) {
    LoopResult result;
    result.before.experiments = cells(0.1, 0.1);
    result.after.experiments = cells(0.1 * by, 0.1 * by);
    for (std::size_t cell = 0; cell < result.before.experiments.size(); ++cell) {
      for (const double apart : {0.006, -0.009, 0.006, -0.009, 0.006}) {
        result.before.experiments[cell].flights.push_back({.x_m = 0.1});
        result.after.experiments[cell].flights.push_back({.x_m = 0.1 * by + apart});
      }
    }
    const std::string page = page_of(result);
    EXPECT_EQ(page.find("flown worse: ") != std::string::npos, by > 1.1);
    EXPECT_EQ(page.find("n missed\"") != std::string::npos, by > 1.1);
    EXPECT_NE(page.find(paired_rule()), std::string::npos);
  }
}

// Catches a page that shows an error of zero for a task that was not flown.
TEST(Page, WithoutTheTrajectorySaysThatItWasNotFlown) {
  const LoopResult result;
  const std::string page = page_of(result);
  EXPECT_EQ(trajectory_errors(result).cells, 0);
  EXPECT_NE(page.find("not flown"), std::string::npos);
  EXPECT_EQ(page.find("0 m before"), std::string::npos);
  EXPECT_TRUE(to_json(result).at("before").at("experiments").at("cells_above_paper").is_null());
}

// Catches a drawing that shrinks with the screen: at 400 px its text was five pixels high.
TEST(Page, DrawingsKeepTheirSizeOnANarrowScreen) {
  LoopResult result;
  result.believed_found["roll"] = {{.parameter = "dead_zone_counts", .believed = 14.0, .found = {15.0, 14.5, 15.5}}};
  const std::string text = page_of(result);
  std::size_t drawings = 0;
  for (std::size_t at = text.find("<svg"); at != std::string::npos; at = text.find("<svg", at + 1), ++drawings) {
    EXPECT_NE(text.substr(at, text.find('>', at) - at).find(" width="), std::string::npos);
  }
  EXPECT_GT(drawings, 0U);
}

/// A minute of roll in which the stick jumps every half second, with a little white noise.
logs::FlightLog rolled(const model::StickAxis& axis) {
  logs::FlightLog log;
  log.size = 6000;
  sim::Random random(11, "rolled");
  model::StickLaw<double> law(axis, log.period_s);
  sysid::AxisDynamics<double> dynamics(axis, log.period_s);
  dynamics.start(0.0, 0.0);
  const auto delay = static_cast<std::size_t>(std::lround(axis.transport_delay_s / log.period_s));
  std::vector<double> command(delay, 0.0);
  double stick = 0.0;
  for (std::size_t k = 0; k < log.size; ++k) {
    stick = k % 50 == 0 ? 300.0 * (2.0 * random.uniform() - 1.0) : stick;
    command.push_back(law.command(stick, 0.0, log.time_s(k)));
    log.of(logs::Signal::kStickRoll).push_back(stick);
    log.of(logs::Signal::kStickPitch).push_back(0.0);
    log.of(logs::Signal::kAttitudeRoll).push_back(dynamics.value() + 0.002 * random.normal());
    dynamics.step(command[k]);
  }
  return log;
}

// Catches a channel that is adopted for a delay difference of half a tick, which the log cannot resolve, and a rule
// that never adopts one.
TEST(PredictsBetter, IsWhatHalfATickOfDelayDoesNotExplain) {
  model::Vehicle truth = mpc::generated::kVehicle;
  truth.roll = {
      .scale_per_count = 9e-4, .natural_frequency_rad_s = 8.0, .damping_ratio = 0.7, .transport_delay_s = 0.05};
  const logs::FlightLog log = rolled(truth.roll);
  const identify::UnseenFlight flight{&log, {{2.0, 58.0}}};
  model::Vehicle believed = truth;
  EXPECT_FALSE(predicts_better(believed, truth, flight, "roll"));
  believed.roll.transport_delay_s = 0.055;
  EXPECT_LT(identify::error_at_1s(truth, flight, "roll"),
            (1.0 - kMinGain) * identify::error_at_1s(believed, flight, "roll"));
  EXPECT_FALSE(predicts_better(believed, truth, flight, "roll"));
  believed.roll.transport_delay_s = 0.08;
  EXPECT_TRUE(predicts_better(believed, truth, flight, "roll"));
  EXPECT_FALSE(predicts_better(truth, believed, flight, "roll"));
  believed = truth;
  believed.roll.scale_per_count *= 0.8;
  EXPECT_TRUE(predicts_better(believed, truth, flight, "roll"));
}

TEST(Prediction, ThatIsWorseIsNamed) {
  LoopResult result;
  result.before.prediction.velocity_m_s[2] = 0.10;
  result.after.prediction.velocity_m_s[2] = 0.12;
  result.before.prediction.roll_rad[2] = 0.10;
  result.after.prediction.roll_rad[2] = 0.09;
  ASSERT_EQ(predicted_worse(result).size(), 1U);
  EXPECT_NE(predicted_worse(result)[0].find("velocity"), std::string::npos);
}

}  // namespace
}  // namespace m100::lab::loop
