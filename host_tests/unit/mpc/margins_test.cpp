// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/gains/tuning/tune.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "firmware/mpc/generated/gain_table.h"

namespace m100::lab::gains {
namespace {

/// Issue "the controller in full": second order 9.36 rad/s, damping 0.68, delay 33 ms.
model::Vehicle second_order() {
  model::Vehicle vehicle;
  for (model::StickAxis* axis : {&vehicle.pitch, &vehicle.roll}) {
    axis->natural_frequency_rad_s = 9.36;
    axis->damping_ratio = 0.68;
    axis->transport_delay_s = 0.033;
  }
  return vehicle;
}

/// First order 87 ms, delay 107 ms. The dynamics that this model lacks disturb the tilt itself, so its process noise is
/// larger.
model::Vehicle first_order() {
  model::Vehicle vehicle;
  for (model::StickAxis* axis : {&vehicle.pitch, &vehicle.roll}) {
    axis->time_constant_s = 0.087;
    axis->transport_delay_s = 0.107;
  }
  vehicle.estimator.tilt_process_rad = 0.3;
  vehicle.estimator.disturbance_process_m_s2 = 0.3;
  return vehicle;
}

/// Margins of the loop with a command in every tick of 10 ms, as in the paper, and an attitude without age.
Margins every_tick_margins(const model::Vehicle& believed, const model::Vehicle& truth, Axis axis,
                           std::size_t pose_age_ticks = 0) {
  return flown_margins_of(believed, truth, axis,
                          {.command_ticks = 1, .attitude_age_ticks = 0, .pose_age_ticks = pose_age_ticks});
}

// An independent trial with another observer of the same kind found 1.21, 7.4, 70 degrees, 211 ms with the input weight
// 35.
TEST(Margins, OfTheIdentifiedAxisAreThoseOfAnIndependentTrial) {
  model::Vehicle vehicle = second_order();
  vehicle.mpc.input = 35;
  vehicle.estimator.velocity_process_m_s = 0.02;  // a faster observer than the default, as in the trial
  vehicle.estimator.tilt_rate_process_rad_s = 1.0;
  vehicle.estimator.disturbance_process_m_s2 = 0.5;
  vehicle.estimator.input_offset_process_rad = 0.003;
  const Margins margins = every_tick_margins(vehicle, vehicle, Axis::kX);
  EXPECT_TRUE(margins.stable);
  EXPECT_NEAR(margins.peak_sensitivity, 1.21, 0.05);
  EXPECT_NEAR(margins.gain_margin, 7.4, 0.8);
  EXPECT_NEAR(margins.phase_margin_rad * 57.3, 70, 10);
  EXPECT_NEAR(margins.delay_margin_s, 0.211, 0.02);
}

// On a first-order axis the observer uses the gyro, whose rate such an axis has not: a loop that leaves this out looked
// robust (1.58, 208 ms).
TEST(Margins, OfTheDefaultWeightsAreAboveTheLimitsForSecondOrderOnly) {
  model::Vehicle first = first_order();
  first.mpc.input = 35;
  for (const Axis axis : {Axis::kX, Axis::kY}) {
    EXPECT_TRUE(is_robust(flown_margins_of(second_order(), second_order(), axis, kVirtualRcTiming)));
    EXPECT_FALSE(is_robust(flown_margins_of(first, first, axis, kVirtualRcTiming)));
  }
}

// The observer knows the age of a pose, which costs some margin. The eigenvalues of the closed loop are an independent
// check of the frequency response: a delay just below the margin must leave the loop stable, one just above must not.
TEST(Margins, AnOldPoseCostsALittleAndTheDelayMarginIsWhereTheLoopReallyBreaks) {
  const model::Vehicle vehicle = second_order();
  double before = 0.0;
  for (const std::size_t age : {0U, 2U, 5U, 8U}) {
    const Margins margins = every_tick_margins(vehicle, vehicle, Axis::kY, age);
    EXPECT_GE(margins.peak_sensitivity, before - 0.005) << age;
    EXPECT_LE(margins.peak_sensitivity, kLargestPeakSensitivity) << age;
    before = margins.peak_sensitivity;
    model::Vehicle late = vehicle;
    late.roll.transport_delay_s += 0.97 * margins.delay_margin_s;
    EXPECT_TRUE(every_tick_margins(vehicle, late, Axis::kY, age).stable) << age;
    late.roll.transport_delay_s = vehicle.roll.transport_delay_s + 1.03 * margins.delay_margin_s;
    EXPECT_FALSE(every_tick_margins(vehicle, late, Axis::kY, age).stable) << age;
  }
}

// Holding a command for 40 ms costs margin, for 20 ms less; so does a stick gain above the believed one.
TEST(FlownMargins, TheHoldAndTheSticksGainCostThem) {
  const model::Vehicle vehicle = second_order();
  const auto delay_margin_s = [&](const model::Vehicle& truth, const LoopTiming& timing) {
    return flown_margins_of(vehicle, truth, Axis::kX, timing).delay_margin_s;
  };
  const double every_tick = delay_margin_s(vehicle, {.command_ticks = 1});
  const double movement = delay_margin_s(vehicle, kMovementTiming);
  const double sticks = delay_margin_s(vehicle, kVirtualRcTiming);
  EXPECT_LT(movement, every_tick);
  EXPECT_LT(sticks, movement);
  model::Vehicle stronger = vehicle;
  stronger.pitch.scale_per_count *= 1.3;
  EXPECT_LT(delay_margin_s(stronger, kVirtualRcTiming), sticks);
}

// An axis with a lead zero turns at once when its command jumps. An observer that trusts the gyro and expects the jump
// one sample too early makes the loop unstable at the rate of the commands: with the numbers that were once shipped, 15
// ms of additional delay were enough.
TEST(FlownMargins, AJumpThatTheGyroSeesAtAnotherTickBreaksTheLoopThatTrustsIt) {
  model::Vehicle vehicle = mpc::generated::kVehicle;
  vehicle.design = {};  // the numbers that were once shipped
  vehicle.estimator.rate_sigma_rad_s = 0.02;
  vehicle.mpc.input = 2.89;
  const Margins margins = flown_margins_of(vehicle, vehicle, Axis::kX, kVirtualRcTiming);
  EXPECT_TRUE(margins.stable);
  EXPECT_LT(margins.delay_margin_s, 0.02);
}

TEST(Margins, NotKnowingTheDelayCostsThem) {
  model::Vehicle truth = second_order();
  truth.pitch.transport_delay_s = 0.1;
  model::Vehicle blind = truth;
  blind.pitch.transport_delay_s = 0.0;
  EXPECT_GT(every_tick_margins(blind, truth, Axis::kX).peak_sensitivity,
            every_tick_margins(truth, truth, Axis::kX).peak_sensitivity + 0.3);
}

// Catches a simulated sensor without the zero that the observer expects in its signal.
TEST(Margins, AKnownLeadZeroCostsLittle) {
  model::Vehicle vehicle = second_order();
  const double without = every_tick_margins(vehicle, vehicle, Axis::kX).peak_sensitivity;
  vehicle.pitch.lead_zero_s = 0.1;
  const Margins with = every_tick_margins(vehicle, vehicle, Axis::kX);
  EXPECT_TRUE(with.stable);
  EXPECT_LT(with.peak_sensitivity, without + 0.4);
}

// The tuning must keep both limits of the loop as flown and the limit of the command's motion. With the margins of the
// paper's loop alone it would choose a faster loop.
TEST(Tuning, FindsTheEdgeOfTheLimitsAsFlown) {
  const model::Vehicle vehicle = second_order();
  const std::vector<Structure> structures{{"own", vehicle}};
  const auto calm = [](const model::Vehicle&) { return 0.0; };
  const Tuned tuned = tune(vehicle, structures, calm);
  ASSERT_TRUE(tuned.keeps_all);
  model::Vehicle at = vehicle;
  at.mpc = tuned.weights;
  const TunedMargins kept = margins_over(at, structures);
  EXPECT_LE(kept.peak_sensitivity, kLargestPeakSensitivity);
  EXPECT_GE(kept.delay_margin_s, kFieldDelayMargin_s);
  at.mpc.input /= 1.1;
  ASSERT_GT(at.mpc.input, kSmallestInputWeight) << "the edge is one of the margins, not of the row";
  const TunedMargins faster = margins_over(at, structures);
  const double over = std::max(faster.peak_sensitivity / kLargestPeakSensitivity,
                               kFieldDelayMargin_s / std::max(faster.delay_margin_s, 1e-3));
  EXPECT_GT(over, 1.0) << "peak sensitivity " << faster.peak_sensitivity << ", delay margin " << faster.delay_margin_s;
}

TEST(Tuning, SaysSoWhereNoInputWeightHoversCalmlyEnough) {
  const model::Vehicle vehicle = second_order();
  const auto moves = [](const model::Vehicle& believed) { return 50.0 + 10.0 * believed.mpc.input; };
  const Tuned tuned = tune(vehicle, {{"own", vehicle}}, moves);
  EXPECT_FALSE(tuned.keeps_all);
  EXPECT_LT(tuned.kept.peak_sensitivity, kLargestPeakSensitivity);
}

}  // namespace
}  // namespace m100::lab::gains
