// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/est/trim_monitor.h"

#include <gtest/gtest.h>

#include <cmath>

#include "firmware/model/default_vehicle.h"

namespace m100::est {
namespace {

constexpr double kTick_s = 0.01;

Estimate<double> hovering(double pitch_offset_rad, double roll_offset_rad, double yaw_rad) {
  Estimate<double> estimate;
  estimate.healthy = true;
  estimate.yaw_rad = yaw_rad;
  // The body's offsets in the yaw-free frame: the inverse of the watch's rotation.
  estimate.x.input_offset_rad = std::cos(yaw_rad) * pitch_offset_rad + std::sin(yaw_rad) * roll_offset_rad;
  estimate.y.input_offset_rad = -std::sin(yaw_rad) * pitch_offset_rad + std::cos(yaw_rad) * roll_offset_rad;
  return estimate;
}

void watch(TrimMonitor<double>& trim, const Estimate<double>& estimate, double seconds) {
  for (int tick = 0; tick < static_cast<int>(seconds / kTick_s); ++tick) {
    const TrimCounts<double>& learned = trim.learned();  // the sticks already cancel this part of the offset
    Estimate<double> left = hovering(learned.pitch * model::paper_vehicle().pitch.scale_per_count,
                                     learned.roll * model::paper_vehicle().roll.scale_per_count, estimate.yaw_rad);
    left.healthy = estimate.healthy;
    left.x.input_offset_rad += estimate.x.input_offset_rad;
    left.y.input_offset_rad += estimate.y.input_offset_rad;
    trim.update(left, true, kTick_s);
  }
}

TEST(TrimMonitor, FindsTheBalancingPointsOfThePaperUnderAnyHeading) {
  const model::Vehicle vehicle = model::paper_vehicle();
  for (const double yaw_rad : {0.0, 0.7, -2.5}) {
    TrimMonitor<double> trim(vehicle);
    // Roll balances at 1080: a stick at 1024 is 56 counts to the left of it.
    const double roll_rad = -56.0 * vehicle.roll.scale_per_count;
    const double pitch_rad = 26.0 * vehicle.pitch.scale_per_count;
    watch(trim, hovering(pitch_rad, roll_rad, yaw_rad), 10.5);
    EXPECT_TRUE(trim.report().drifted);
    EXPECT_NEAR(trim.report().roll_counts, 56.0, 0.01);
    EXPECT_NEAR(trim.report().pitch_counts, -26.0, 0.01);
    EXPECT_NEAR(trim.learned().roll, 56.0, 0.5) << "after five time constants";
    EXPECT_NEAR(trim.learned().pitch, -26.0, 0.5);
  }
}

// Catches a lean with the wind instead of against it, and a wind that does not rotate with the heading.
TEST(TrimMonitor, KnowsTheSticksThatHoldThePlaceInWind) {
  const model::Vehicle vehicle = model::paper_vehicle();
  const TrimMonitor<double> trim(vehicle);
  constexpr double kPush_m_s2 = 0.5;
  const double lean = kPush_m_s2 / model::kGravity_m_s2;
  Estimate<double> estimate = hovering(26.0 * vehicle.pitch.scale_per_count, 0.0, 0.0);
  estimate.x.disturbance_m_s2 = kPush_m_s2;  // from behind: nose up, stick back
  estimate.y.disturbance_m_s2 = kPush_m_s2;  // from the right to the left: stick to the right
  EXPECT_NEAR(trim.holding(estimate).pitch, -26.0 - lean / vehicle.pitch.scale_per_count, 0.01);
  EXPECT_NEAR(trim.holding(estimate).roll, lean / vehicle.roll.scale_per_count, 0.01);
  Estimate<double> turned = hovering(0.0, 0.0, 0.5 * core::kPi);
  turned.x.disturbance_m_s2 = kPush_m_s2;  // the nose points along world +y, so the wind comes from the left
  EXPECT_NEAR(trim.holding(turned).pitch, 0.0, 0.01);
  EXPECT_NEAR(trim.holding(turned).roll, -lean / vehicle.roll.scale_per_count, 0.01);
}

TEST(TrimMonitor, LearnsNoTrimThatNoVehicleFileMayHave) {
  TrimMonitor<double> trim(model::paper_vehicle());
  watch(trim, hovering(0.6, 0.0, 0.0), 20.0);  // about 700 counts
  EXPECT_GT(trim.learned().pitch, -300.0);
  EXPECT_EQ(trim.learned_share(), 0.0) << "the observer keeps what the sticks do not take";
}

TEST(TrimMonitor, SaysNothingBeforeItHasSeenEnoughHover) {
  const model::Vehicle vehicle = model::paper_vehicle();
  TrimMonitor<double> trim(vehicle);
  const Estimate<double> estimate = hovering(0.1, 0.0, 0.0);
  watch(trim, estimate, 9.0);
  EXPECT_FALSE(trim.report().converged);
  EXPECT_FALSE(trim.report().drifted);
  for (int tick = 0; tick < 1000; ++tick) {
    trim.update(estimate, false, kTick_s);  // not a hover: the reference moves
    Estimate<double> fast = estimate;
    fast.x.velocity_m_s = 1.0;
    trim.update(fast, true, kTick_s);
  }
  EXPECT_FALSE(trim.report().converged);
}

TEST(TrimMonitor, FollowsADriftWithinThreeTimeConstantsAndForgetsIt) {
  const model::Vehicle vehicle = model::paper_vehicle();
  TrimMonitor<double> trim(vehicle);
  watch(trim, hovering(0.0, 0.0, 0.0), 20.0);
  EXPECT_FALSE(trim.report().drifted);
  const double counts = 30.0;
  watch(trim, hovering(0.0, -counts * vehicle.roll.scale_per_count, 0.0), 3.0 * TrimMonitor<double>::kTimeConstant_s);
  EXPECT_TRUE(trim.report().drifted);
  EXPECT_NEAR(trim.report().roll_counts, counts, 0.06 * counts);
  watch(trim, hovering(0.0, 0.0, 0.0), 3.0 * TrimMonitor<double>::kTimeConstant_s);
  EXPECT_FALSE(trim.report().drifted);
}

}  // namespace
}  // namespace m100::est
