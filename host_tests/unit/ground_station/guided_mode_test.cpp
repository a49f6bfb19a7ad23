// SPDX-License-Identifier: BSD-3-Clause
// What the orders of a room mean, and how the battery settings are written into a log.
#include "firmware/companion/ground_station/guided_mode.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "firmware/companion/ground_station/return_to_start.h"

namespace m100::companion {
namespace {

TEST(PauseOrder, LessThanHalfOfOneIsToHold) {
  const auto with = [](float param1, std::uint16_t command) {
    mavlink::CommandLong order;
    order.param1 = param1;
    order.command = command;
    return order;
  };
  EXPECT_FALSE(is_hold_command(with(0.5F, kPauseContinue)));
  EXPECT_TRUE(is_hold_command(with(std::nextafter(0.5F, 0.F), kPauseContinue)));
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(is_hold_command(with(nan, kPauseContinue)));
  EXPECT_FALSE(is_hold_command(with(0.F, kPauseContinue + 1)));
}

// A replay reads the settings from the log. Would catch a replay that flies home at another speed than the flight did.
TEST(HomeNote, IsReadAsItWasWritten) {
  EXPECT_EQ(ReturnSettings{}.low_percent, 0.0) << "without the key the battery is nobody's business";
  ReturnSettings settings;
  settings.low_percent = 30.0;
  settings.limits.speed_m_s = 0.1;
  settings.limits.acceleration_m_s2 = 1.0 / 3.0;
  settings.limits.yaw_rate_rad_s = 0.7;
  const std::optional<ReturnSettings> read = home_of_note(home_note(settings));
  ASSERT_TRUE(read);
  EXPECT_EQ(read->low_percent, settings.low_percent);
  EXPECT_EQ(read->limits.speed_m_s, settings.limits.speed_m_s);
  EXPECT_EQ(read->limits.acceleration_m_s2, settings.limits.acceleration_m_s2);
  EXPECT_EQ(read->limits.yaw_rate_rad_s, settings.limits.yaw_rate_rad_s);
  for (const char* const note : {"", "30", "30 1 1", "much 1 1 1", "30 fast 1 1"}) {
    EXPECT_FALSE(home_of_note(note)) << note;
  }
}

}  // namespace
}  // namespace m100::companion
