// SPDX-License-Identifier: BSD-3-Clause
// The plain pose packet of a room, read and converted: every text that is not a pose is refused, and the axes are those
// of MAVLink.
#include "host_tests/lab/bridge/plain_pose.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <string_view>

namespace m100::lab::bridge {
namespace {

std::optional<PlainPose> parsed(std::string_view text) { return parse_packet(std::as_bytes(std::span(text))); }

TEST(PlainPose, IsEightNumbersInTextOrBytes) {
  for (const char* const text : {"1.5 1 2 3 1 0 0 0", "1.5,1,2,3,1,0,0,0", " 1.5, 1,\t2 3 1e0 0 0 0\r\n"}) {
    const std::optional<PlainPose> pose = parsed(text);
    ASSERT_TRUE(pose) << text;
    EXPECT_EQ(pose->t_s, 1.5);
    EXPECT_EQ(pose->position_m.z(), 3.0);
    EXPECT_EQ(pose->body_to_world.w, 1.0);
  }
  const std::array<double, 8> numbers{1.5, 1.0, 2.0, 3.0, 1.0, 0.0, 0.0, 0.0};
  const std::optional<PlainPose> pose = parse_packet(std::as_bytes(std::span(numbers)));
  ASSERT_TRUE(pose);
  EXPECT_EQ(pose->position_m.y(), 2.0);
}

TEST(PlainPose, WhatIsNoPoseIsRefused) {
  for (const char* const text : {"", "hello", "1 1 2 3 1 0 0", "1 1 2 3 1 0 0 0 0", "1 1 2 3 1 0 0 0x",
                                 "1 nan 2 3 1 0 0 0", "1 1 2 inf 1 0 0 0", "1 1 2 3 0 0 0 0", "1 1 2 3 1 1 0 0",
                                 "1 1001 2 3 1 0 0 0", "-1 1 2 3 1 0 0 0", "1e300 1 2 3 1 0 0 0", "1;1;2;3;1;0;0;0"}) {
    EXPECT_FALSE(parsed(text)) << text;
  }
  std::array<double, 8> numbers{1.5, 1.0, 2.0, 3.0, std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0, 0.0};
  EXPECT_FALSE(parse_packet(std::as_bytes(std::span(numbers))));
  EXPECT_FALSE(parse_packet(std::as_bytes(std::span(numbers)).first(63)));
}

struct Turned {
  const char* name;
  Axes axes;
  std::array<float, 3> ned;
  double heading_rad;  ///< clockwise from x of the wire, of a body that looks along the room's x
};
struct Turning : ::testing::TestWithParam<Turned> {};
// A body at (1, 2, 3) in the room that points along x, with its nose 0.1 rad down.
TEST_P(Turning, IsThatOfTheWire) {
  PlainPose pose{.t_s = 0.0, .position_m = {1.0, 2.0, 3.0}, .body_to_world = {}};
  const double nose_down = GetParam().axes == Axes::kNed ? -0.05 : 0.05;  // about y, which points left, or right in NED
  pose.body_to_world = {std::cos(nose_down), 0.0, std::sin(nose_down), 0.0};
  const mavlink::AttPosMocap message = message_of(pose, GetParam().axes, 77);
  EXPECT_EQ(message.time_usec, 77U);
  EXPECT_EQ((std::array{message.x, message.y, message.z}), GetParam().ned);
  const core::Euler<double> euler =
      core::euler_of(core::Quaternion<double>{static_cast<double>(message.q[0]), static_cast<double>(message.q[1]),
                                              static_cast<double>(message.q[2]), static_cast<double>(message.q[3])});
  EXPECT_NEAR(euler.pitch_rad, -0.1, 1e-6) << "nose up is positive on the wire";
  EXPECT_NEAR(euler.roll_rad, 0.0, 1e-6);
  EXPECT_NEAR(euler.yaw_rad, GetParam().heading_rad, 1e-6);
}
INSTANTIATE_TEST_SUITE_P(Table, Turning,
                         ::testing::Values(Turned{"Nwu", Axes::kNwu, {1.F, -2.F, -3.F}, 0.0},
                                           Turned{"Ned", Axes::kNed, {1.F, 2.F, 3.F}, 0.0},
                                           Turned{"Enu", Axes::kEnu, {2.F, 1.F, -3.F}, core::kPi / 2.0}),
                         [](const auto& turned) { return turned.param.name; });

TEST(PlainPose, AxesHaveNames) {
  EXPECT_EQ(axes_of("enu"), Axes::kEnu);
  EXPECT_FALSE(axes_of("xyz"));
}

}  // namespace
}  // namespace m100::lab::bridge
