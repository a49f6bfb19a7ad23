// SPDX-License-Identifier: BSD-3-Clause
// Time stamps of a pose on two clocks, and seconds as numbers.
#include "firmware/core/pose.h"

#include <gtest/gtest.h>

namespace m100::core {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

Pose<double> pose() {
  Pose<double> out;
  out.is_new = true;
  out.sequence = 7;
  out.captured = SenderTime(milliseconds(1000));
  out.to_ours = milliseconds(-400);
  out.offset = {.known = true, .to_ours = milliseconds(-390), .bound = milliseconds(3)};
  out.arrived = TimePoint(milliseconds(620));
  out.position_w_m = {1.0, -2.0, 3.0};
  out.yaw_rad = 0.5;
  out.time_sigma_s = 0.25;
  out.position_variance_m2 = {4.0, 5.0, 6.0};
  return out;
}

TEST(Pose, IsCapturedOnTheSendersClockAndAgesOnOurs) {
  Pose<double> one = pose();
  EXPECT_EQ(one.captured_at(), TimePoint(milliseconds(600)));
  EXPECT_EQ(one.age(TimePoint(milliseconds(650))), milliseconds(50));
  EXPECT_EQ(one.age(TimePoint(milliseconds(590))), milliseconds(-10));
  one.set_captured_at(TimePoint(milliseconds(30)));
  EXPECT_EQ(one.captured_at(), TimePoint(milliseconds(30)));
  EXPECT_EQ(one.to_ours, Duration{0});
}

TEST(Pose, IsNothingUntilItComes) {
  const Pose<float> none;
  EXPECT_FALSE(none.is_new);
  EXPECT_FALSE(none.offset.known);
  EXPECT_EQ(none.sequence, 0U);
  EXPECT_EQ(none.captured_at(), TimePoint{});
  EXPECT_EQ(none.arrived, TimePoint{});
  EXPECT_EQ(none.position_w_m.norm() + none.position_variance_m2.norm() + none.yaw_rad + none.time_sigma_s, 0.0F);
  EXPECT_EQ(none.offset.to_ours + none.offset.bound, Duration{0});
}

TEST(Pose, KeepsEverythingInAnotherScalar) {
  const Pose<float> other = pose().cast<float>();
  EXPECT_TRUE(other.is_new);
  EXPECT_EQ(other.sequence, 7U);
  EXPECT_EQ(other.captured, SenderTime(milliseconds(1000)));
  EXPECT_EQ(other.to_ours, milliseconds(-400));
  EXPECT_TRUE(other.offset.known);
  EXPECT_EQ(other.offset.to_ours, milliseconds(-390));
  EXPECT_EQ(other.offset.bound, milliseconds(3));
  EXPECT_EQ(other.arrived, TimePoint(milliseconds(620)));
  EXPECT_EQ(other.position_w_m.y(), -2.0F);
  EXPECT_EQ(other.yaw_rad, 0.5F);
  EXPECT_EQ(other.time_sigma_s, 0.25F);
  EXPECT_EQ(other.position_variance_m2.z(), 6.0F);
}

// Would catch a conversion that is truncated to 32 bits, which end after half an hour of flight.
TEST(Seconds, AreMicrosecondsOverAMillionHoweverMany) {
  EXPECT_EQ(seconds<double>(microseconds(1)), 1e-6);
  EXPECT_EQ(seconds<double>(microseconds(-2500000)), -2.5);
  for (const std::int64_t count : {std::int64_t{2147483647}, std::int64_t{2147483648}, std::int64_t{-2147483649},
                                   std::int64_t{4294967296}, std::int64_t{86400000000}}) {
    EXPECT_EQ(seconds<double>(Duration(count)), static_cast<double>(count) / 1e6);
    EXPECT_EQ(seconds<float>(Duration(count)), static_cast<float>(count) / 1e6F);
  }
  EXPECT_EQ(kTickPeriod, milliseconds(10));
}

}  // namespace
}  // namespace m100::core
