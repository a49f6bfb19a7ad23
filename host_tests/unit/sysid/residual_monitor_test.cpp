// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/sysid/residual_monitor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "host_tests/lab/identify/model/axis/axis_blocks.h"

namespace m100::sysid {
namespace {

constexpr double kPeriod_s = 0.01;

model::StickAxis measured_roll() {
  return {.scale_per_count = 9.1e-4,
          .natural_frequency_rad_s = 7.2,
          .damping_ratio = 0.75,
          .transport_delay_s = 0.0552,
          .lead_zero_s = 0.11,
          .dead_zone_counts = 14.9};
}

/// Active stick movements of a hand, and the response of `truth` with a little noise.
lab::identify::AxisData fly(const model::StickAxis& truth, std::size_t size, double noise_rad) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  lab::identify::AxisData data;
  data.period_s = kPeriod_s;
  model::StickLaw<double> law(truth, kPeriod_s);
  std::vector<double> commands;
  double target = 0.0;
  double stick = 0.0;
  for (std::size_t i = 0; i < size; ++i) {
    target = i % 70 == 0 ? 180.0 * normal(random) : target;
    stick += 0.12 * (target - stick);
    data.stick.push_back(std::round(stick));
    commands.push_back(law.command(data.stick.back(), 0.0, 0.0));
  }
  std::vector<double> late(size);
  lab::identify::arrived_commands(commands, truth, kPeriod_s, 0, late);
  AxisDynamics<double> dynamics(truth, kPeriod_s);
  for (const double command : late) {
    data.measured.push_back(dynamics.value() + noise_rad * normal(random));
    dynamics.step(command);
  }
  data.valid.assign(size, 1);
  return data;
}

ResidualReport<double> watch(const model::StickAxis& believed, const lab::identify::AxisData& data,
                             double expected_rms) {
  AxisResidual<double> residual(believed, expected_rms, kPeriod_s);
  for (std::size_t i = 0; i < data.stick.size(); ++i) {
    residual.update(data.stick[i], 0.0, data.measured[i]);
  }
  return residual.report();
}

// The monitor on the vehicle must compute what the host computes: the same block, the same start, the same error.
TEST(AxisResidual, EqualsTheHostsSimulationError) {
  RecordProperty("promise", "R13");
  const lab::identify::AxisData data = fly(measured_roll(), 266, 0.002);
  model::StickAxis believed = measured_roll();
  believed.scale_per_count *= 1.1;
  believed.transport_delay_s = 0.0237;
  const lab::identify::AxisBlocks host(data, {{0.05, 2.55}});
  ASSERT_EQ(host.size(), 1U);
  const ResidualReport<double> seen = watch(believed, data, 0.01);
  ASSERT_EQ(seen.blocks, 1U);
  EXPECT_NEAR(seen.block_rms, host.rmse(believed), 1e-12);
}

TEST(AxisResidual, StaysQuietWhileTheModelHolds) {
  const ResidualReport<double> seen = watch(measured_roll(), fly(measured_roll(), 6000, 0.002), 0.004);
  EXPECT_GT(seen.blocks, 20U);
  EXPECT_EQ(seen.blocks_over, 0U) << "else a single block would do where two in a row are asked for";
  EXPECT_LT(seen.ratio, 1.0);
  EXPECT_FALSE(seen.departed);
}

// Only a part of the gain, or a little time, is wrong: the error is no larger than that of a correct model.
TEST(AxisResidual, NoticesAThirdOfTheGain) {
  RecordProperty("promise", "R17");
  for (const double factor : {0.7, 1.3}) {
    model::StickAxis truth = measured_roll();
    truth.scale_per_count *= factor;
    const ResidualReport<double> seen = watch(measured_roll(), fly(truth, 3000, 0.01), 0.008);
    EXPECT_TRUE(seen.response_departed) << "factor " << factor;
    EXPECT_NEAR(seen.response.gain, factor - 1.0, 0.08);
    EXPECT_NEAR(seen.response.late_s, 0.0, 0.01);
  }
}

TEST(AxisResidual, NoticesSixtyMilliseconds) {
  RecordProperty("promise", "R17");
  model::StickAxis truth = measured_roll();
  truth.transport_delay_s += 0.06;
  const ResidualReport<double> seen = watch(measured_roll(), fly(truth, 3000, 0.01), 0.008);
  EXPECT_TRUE(seen.response_departed);
  EXPECT_NEAR(seen.response.late_s, 0.06, 0.01);
}

// The change must be noticed within ten seconds, wherever in a block it happens.
TEST(AxisResidual, NoticesAChangeWithinTenSeconds) {
  RecordProperty("promise", "R17");
  model::StickAxis late = measured_roll();
  late.transport_delay_s += 0.06;
  const lab::identify::AxisData healthy = fly(measured_roll(), 6000, 0.007);
  const lab::identify::AxisData changed = fly(late, 6000, 0.007);
  for (std::size_t at = 2000; at < 2260; at += 37) {
    AxisResidual<double> residual(measured_roll(), 0.008, kPeriod_s);
    for (std::size_t i = 0; i < at + 1000; ++i) {
      residual.update(healthy.stick[i], 0.0, i < at ? healthy.measured[i] : changed.measured[i]);
      ASSERT_TRUE(i >= at || !residual.report().departed) << "a false alarm at sample " << i;
    }
    EXPECT_TRUE(residual.report().departed) << "changed at sample " << at;
  }
}

// In a hover the prediction follows small corrections against disturbances; they must not be taken for a lost gain.
TEST(AxisResidual, BelievesNoResponseWithoutSwing) {
  lab::identify::AxisData hover = fly(measured_roll(), 3000, 0.0);
  for (std::size_t i = 0; i < hover.measured.size(); ++i) {
    hover.stick[i] = std::round(20.0 * std::sin(0.03 * static_cast<double>(i)));
    hover.measured[i] = -0.008 * std::sin(0.03 * static_cast<double>(i));
  }
  const ResidualReport<double> seen = watch(measured_roll(), hover, 0.008);
  EXPECT_GT(seen.blocks, 5U);
  EXPECT_FALSE(seen.departed);
}

// The vehicle departs from the model: half of the gain is lost, or 150 ms of delay are added.
TEST(AxisResidual, NoticesALostGain) {
  model::StickAxis truth = measured_roll();
  truth.scale_per_count *= 0.5;
  const ResidualReport<double> seen = watch(measured_roll(), fly(truth, 3000, 0.002), 0.008);
  EXPECT_TRUE(seen.departed) << "ratio " << seen.ratio;
}

TEST(AxisResidual, NoticesADelay) {
  model::StickAxis truth = measured_roll();
  truth.transport_delay_s += 0.15;
  const ResidualReport<double> seen = watch(measured_roll(), fly(truth, 3000, 0.002), 0.008);
  EXPECT_TRUE(seen.departed) << "ratio " << seen.ratio;
}

// An offset is a trim, which est::TrimMonitor reports; this monitor must not.
TEST(AxisResidual, LeavesAnOffsetToTheTrim) {
  lab::identify::AxisData data = fly(measured_roll(), 3000, 0.002);
  for (double& measured : data.measured) {
    measured += 0.05;
  }
  EXPECT_FALSE(watch(measured_roll(), data, 0.008).departed);
}

// A block with a gap must be discarded: it has nothing to compare the model with.
TEST(AxisResidual, ThrowsABlockWithAGapAway) {
  const lab::identify::AxisData data = fly(measured_roll(), 500, 0.002);
  AxisResidual<double> residual(measured_roll(), 0.008, kPeriod_s);
  for (std::size_t i = 0; i < data.stick.size(); ++i) {
    const bool lost = i % 200 == 150;
    residual.update(data.stick[i], 0.0, lost ? std::numeric_limits<double>::quiet_NaN() : data.measured[i]);
  }
  EXPECT_EQ(residual.report().blocks, 0U);
}

// Catches a stick value that is not a number and spoils the prediction for good: it must cost only its block, like a
// lost measurement.
TEST(AxisResidual, ThrowsABlockWithAStickThatIsNoNumberAway) {
  lab::identify::AxisData data = fly(measured_roll(), 900, 0.002);
  data.stick[150] = std::numeric_limits<double>::infinity();
  const ResidualReport<double> seen = watch(measured_roll(), data, 0.008);
  EXPECT_EQ(seen.blocks, 2U) << "of three, the first is lost";
  EXPECT_LT(seen.ratio, 1.0);
}

// The flight program uses float: its residual must agree within a few millionths of the axis' range.
TEST(AxisResidual, FloatAgreesWithDouble) {
  const lab::identify::AxisData data = fly(measured_roll(), 3000, 0.002);
  AxisResidual<float> residual(measured_roll(), 0.008F, 0.01F);
  for (std::size_t i = 0; i < data.stick.size(); ++i) {
    residual.update(static_cast<float>(data.stick[i]), 0.F, static_cast<float>(data.measured[i]));
  }
  const ResidualReport<double> seen = watch(measured_roll(), data, 0.008);
  EXPECT_EQ(residual.report().blocks, seen.blocks);
  EXPECT_NEAR(static_cast<double>(residual.report().block_rms), seen.block_rms, 2e-5);
}

TEST(ResidualMonitor, SaysWhichChannelIsWorst) {
  model::Vehicle vehicle;
  vehicle.roll.natural_frequency_rad_s = vehicle.pitch.natural_frequency_rad_s = 8.0;
  vehicle.roll.damping_ratio = vehicle.pitch.damping_ratio = 0.7;
  vehicle.yaw_rate.scale_per_count = 2.24e-3;
  vehicle.yaw_rate.time_constant_s = 0.19;
  vehicle.climb.scale_per_count = 2.65e-3;
  vehicle.climb.time_constant_s = 0.33;
  ResidualMonitor<double> monitor(vehicle, {}, kPeriod_s, 0.015);
  EXPECT_FALSE(monitor.departed()) << "before anything has flown";
  for (int i = 0; i < 600; ++i) {
    ResidualMonitor<double>::Sample sample;
    sample.measured = {0.0, 0.2 * std::sin(0.03 * i), 0.0, 0.0};  // pitch moves without a stick command
    monitor.update(sample);
  }
  EXPECT_EQ(monitor.worst(), MonitoredAxis::kPitch);
  EXPECT_TRUE(monitor.departed());
  EXPECT_TRUE(monitor.report(MonitoredAxis::kPitch).departed);
  EXPECT_FALSE(monitor.report(MonitoredAxis::kRoll).departed);
}

}  // namespace
}  // namespace m100::sysid
