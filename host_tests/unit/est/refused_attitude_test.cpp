// SPDX-License-Identifier: BSD-3-Clause
// How the observer reacts when the gate refuses attitudes, and the names of its recoveries.
#include <gtest/gtest.h>

#include <set>
#include <string_view>

#include "firmware/est/filter/disturbance_ekf.h"
#include "host_tests/unit/est/observed_vehicle.h"
#include "host_tests/unit/est/scalars.h"

namespace m100::est::refused {
namespace {

template <typename Ekf>
class RefusedAttitude : public ::testing::Test {};
TYPED_TEST_SUITE(RefusedAttitude, Scalars);

// Catches an observer that keeps a tilt which every attitude contradicts, and one that gives it up too early.
TYPED_TEST(RefusedAttitude, StartsItAnewAfterHalfASecond) {
  using Real = typename TypeParam::Real;
  typename TypeParam::Filter filter(vehicle());
  Estimate<Real> estimate;
  const auto fly = [&](int ticks, Real roll_rad) {
    for (int i = 0; i < ticks; ++i) {
      Measurement<Real> measured;
      measured.attitude.is_new = true;
      measured.attitude.roll_rad = roll_rad;
      measured.pose.is_new = true;
      measured.pose.set_captured_at(measured.now);
      estimate = filter.update(measured, {}, core::kTickPeriod);
    }
  };
  fly(500, Real(0));
  ASSERT_TRUE(estimate.healthy);
  ASSERT_EQ(filter.counters().attitudes_refused, 0U);
  fly(49, Real(0.5));
  EXPECT_EQ(filter.counters().attitudes_refused, 49U);
  EXPECT_EQ(filter.counters().last_recovery, ResetReason::kNone);
  fly(1, Real(0.5));
  EXPECT_EQ(filter.counters().last_recovery, ResetReason::kAttitude);
  EXPECT_FALSE(estimate.healthy);
  fly(20, Real(0.5));
  EXPECT_EQ(filter.counters().attitudes_refused, 50U) << "it has begun at the attitude that is said";
}

TEST(RecoveryName, IsAnotherWordForEach) {
  std::set<std::string_view> words;
  for (const ResetReason recovery : {ResetReason::kNone, ResetReason::kPoseMoved, ResetReason::kLongDropout,
                                     ResetReason::kAttitude, ResetReason::kNotFinite, static_cast<ResetReason>(99)}) {
    EXPECT_TRUE(words.insert(name(recovery)).second && name(recovery).size() >= 4U) << name(recovery);
  }
  EXPECT_EQ(name(ResetReason::kNotFinite), "a state was not a number");
}

}  // namespace
}  // namespace m100::est::refused
