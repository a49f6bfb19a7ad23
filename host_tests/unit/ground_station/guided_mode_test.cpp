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

// Would catch a replay that flies a stream by other limits, or takes set points of another sender, than the flight did;
// and one that flies the goals of an older log, without the word `stream`, as a stream.
TEST(GoalsNote, IsReadAsItWasWrittenAndAnOlderOneHasNoStream) {
  GoalSettings settings;
  settings.limits.speed_m_s = 1.0 / 3.0;
  settings.stream = StreamLimits{.speed_m_s = 2.1, .acceleration_m_s2 = 0.7, .climb_m_s = 1.1, .yaw_rate_rad_s = 0.3};
  settings.only = mavlink::Address{.system = 1, .component = 240};
  const std::optional<GoalSettings> read = goals_of_note(goals_note(settings));
  ASSERT_TRUE(read && read->stream && read->only);
  EXPECT_EQ(read->limits.speed_m_s, settings.limits.speed_m_s);
  EXPECT_EQ(read->stream->speed_m_s, 2.1);
  EXPECT_EQ(read->stream->acceleration_m_s2, 0.7);
  EXPECT_EQ(read->stream->climb_m_s, 1.1);
  EXPECT_EQ(read->stream->yaw_rate_rad_s, 0.3);
  EXPECT_TRUE(*read->only == *settings.only);
  const std::optional<GoalSettings> older = goals_of_note("1.5 2 0.8");
  ASSERT_TRUE(older);
  EXPECT_FALSE(older->stream || older->only);
  for (const char* const note : {"", "1 1", "1 1 1 stream 1 1 1", "1 1 1 from 1", "1 1 1 other"}) {
    EXPECT_FALSE(goals_of_note(note)) << note;
  }
}

}  // namespace
}  // namespace m100::companion
