// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/link/pose/pose_decoder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "firmware/core/frames.h"
#include "protocol/mavlink/parser.h"
#include "protocol/mavlink/pose_messages.h"

namespace m100::link {
namespace {

using mavlink::AttPosMocap;
using mavlink::Odometry;
using mavlink::VisionPositionEstimate;

template <typename Message>
core::Expected<core::Pose<double>> read(const Message& message, PoseAside* aside = nullptr) {
  mavlink::Parser parser;
  PoseAside unread;
  const mavlink::Frame frame = mavlink::encode(message, {1, 197}, 0);
  EXPECT_EQ(parser.push(frame.bytes()), frame.size);
  const core::Expected<mavlink::FrameView> view = parser.poll();
  EXPECT_TRUE(view.has_value());
  return decode_pose(*view, aside != nullptr ? *aside : unread);
}
PoseAside aside_of(const auto& message) {
  PoseAside beside;
  (void)read(message, &beside);
  return beside;
}

/// The same pose in each of the three messages, in NED, with a heading clockwise from above.
struct Wire {
  std::array<float, 3> ned_m;
  float heading_rad;
};
std::vector<core::Expected<core::Pose<double>>> in_all_messages(const Wire& wire) {
  const float half = 0.5F * wire.heading_rad;
  const std::array<float, 4> q{std::cos(half), 0.F, 0.F, std::sin(half)};
  const auto& [x, y, z] = wire.ned_m;
  return {read(AttPosMocap{.time_usec = 5, .q = q, .x = x, .y = y, .z = z}),
          read(VisionPositionEstimate{.usec = 5, .x = x, .y = y, .z = z, .yaw = wire.heading_rad}),
          read(Odometry{.time_usec = 5, .x = x, .y = y, .z = z, .q = q, .frame_id = 1, .child_frame_id = 12})};
}

struct AxisCase {
  const char* name;
  Wire wire;
  std::array<double, 3> nwu_m;
  double yaw_rad;
};
class PoseAxes : public ::testing::TestWithParam<AxisCase> {};

// The six directions of the world and both turns: each shows a wrong sign or a swapped axis.
TEST_P(PoseAxes, AreThoseOfOurWorldInEveryMessage) {
  const AxisCase& one = GetParam();
  for (const core::Expected<core::Pose<double>>& pose : in_all_messages(one.wire)) {
    ASSERT_TRUE(pose.has_value());
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(pose->position_w_m[axis], one.nwu_m[static_cast<std::size_t>(axis)], 1e-6) << axis;
    }
    EXPECT_NEAR(pose->yaw_rad, one.yaw_rad, 1e-6);
    EXPECT_EQ(pose->captured.time_since_epoch().count(), 5);
  }
}

INSTANTIATE_TEST_SUITE_P(Six, PoseAxes,
                         ::testing::Values(AxisCase{"North", {{1.F, 0.F, 0.F}, 0.F}, {1.0, 0.0, 0.0}, 0.0},
                                           AxisCase{"South", {{-1.F, 0.F, 0.F}, 0.F}, {-1.0, 0.0, 0.0}, 0.0},
                                           AxisCase{"East", {{0.F, 1.F, 0.F}, 0.F}, {0.0, -1.0, 0.0}, 0.0},
                                           AxisCase{"West", {{0.F, -1.F, 0.F}, 0.F}, {0.0, 1.0, 0.0}, 0.0},
                                           AxisCase{"Down", {{0.F, 0.F, 1.F}, 0.F}, {0.0, 0.0, -1.0}, 0.0},
                                           AxisCase{"Up", {{0.F, 0.F, -1.F}, 0.F}, {0.0, 0.0, 1.0}, 0.0},
                                           AxisCase{"TurnedRight", {{0.F, 0.F, 0.F}, 0.5F}, {0.0, 0.0, 0.0}, -0.5},
                                           AxisCase{"TurnedLeft", {{0.F, 0.F, 0.F}, -2.F}, {0.0, 0.0, 0.0}, 2.0}),
                         [](const auto& one) { return one.param.name; });

// Catches a heading that is taken from a wrong axis of a banked aircraft: 0.3 rad nose up, 0.4 rad right side down, 1
// rad to the east.
TEST(PoseReading, KeepsTheHeadingOfABankedAircraft) {
  const auto q = core::quaternion_of(core::Euler<double>{.roll_rad = 0.4, .pitch_rad = 0.3, .yaw_rad = 1.0});
  const auto f = [](double value) { return static_cast<float>(value); };
  const auto mocap = read(AttPosMocap{.time_usec = 5, .q = {f(q.w), f(q.x), f(q.y), f(q.z)}});
  const auto vision = read(VisionPositionEstimate{.usec = 5, .roll = 0.4F, .pitch = 0.3F, .yaw = 1.F});
  ASSERT_TRUE(mocap && vision);
  EXPECT_NEAR(mocap->yaw_rad, -1.0, 1e-6);
  EXPECT_NEAR(vision->yaw_rad, -1.0, 1e-6);
}

TEST(PoseReading, NumbersThatCannotBeAreRefusedAtTheBorder) {
  RecordProperty("promise", "R11");
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const AttPosMocap good{.time_usec = 5, .q = {1.F, 0.F, 0.F, 0.F}};
  ASSERT_TRUE(read(good));
  std::vector<AttPosMocap> bad(5, good);
  bad[0].x = nan;
  bad[1].q[1] = nan;
  bad[2].y = std::numeric_limits<float>::infinity();
  bad[3].time_usec = ~std::uint64_t{0};
  bad[4].q = {1.0109F, 0.F, 0.F, 0.F};  // 2.2 % in the square
  for (std::size_t i = 0; i < bad.size(); ++i) {
    EXPECT_EQ(read(bad[i]).status(), core::Status::kOutOfRange) << i;
  }
  EXPECT_EQ(read(VisionPositionEstimate{.usec = 5, .yaw = nan}).status(), core::Status::kOutOfRange);
  EXPECT_EQ(read(VisionPositionEstimate{.usec = 5, .roll = 1e30F}).status(), core::Status::kOutOfRange);
  for (std::uint8_t frame = 0; frame < 30; ++frame) {  // forward, left, up would fly to the wrong side
    const bool is_ned = frame == 1 || frame == 14 || frame == 16 || frame == 18 || frame == 20;
    EXPECT_EQ(read(Odometry{.time_usec = 5, .q = {1.F, 0.F, 0.F, 0.F}, .frame_id = frame}).has_value(), is_ned);
  }
  EXPECT_EQ(read(mavlink::Timesync{.tc1 = 1, .ts1 = 1}).status(), core::Status::kNotReady);
}

TEST(PoseReading, EachNumberIsTakenUpToItsLastAndRefusedFromTheNextOn) {
  const AttPosMocap good{.time_usec = 5, .q = {1.F, 0.F, 0.F, 0.F}};
  std::vector<AttPosMocap> last(5, good), next(5, good);
  const auto beyond = [](float value) { return std::nextafter(value, 2.F * value); };
  last[0].x = -1000.F, next[0].x = beyond(-1000.F);
  last[1].y = 1000.F, next[1].y = beyond(1000.F);
  last[2].z = 1000.F, next[2].z = beyond(1000.F);
  last[3].z = -1000.F, next[3].z = beyond(-1000.F);
  last[4].time_usec = std::uint64_t{1} << 53U, next[4].time_usec = (std::uint64_t{1} << 53U) + 1;
  for (std::size_t i = 0; i < last.size(); ++i) {
    EXPECT_TRUE(read(last[i])) << i;
    EXPECT_EQ(read(next[i]).status(), core::Status::kOutOfRange) << i;
  }
}

TEST(PoseReading, VariancesAreThoseOfTheDiagonal) {
  AttPosMocap message{.time_usec = 5, .q = {1.F, 0.F, 0.F, 0.F}};
  message.covariance[0] = 0.25F;
  message.covariance[1] = 9.F;
  message.covariance[6] = 0.5F;
  message.covariance[11] = 0.75F;
  const auto pose = read(message);
  ASSERT_TRUE(pose);
  EXPECT_EQ(pose->position_variance_m2.x(), 0.25);
  EXPECT_EQ(pose->position_variance_m2.y(), 0.5);
  EXPECT_EQ(pose->position_variance_m2.z(), 0.75);
  EXPECT_TRUE(pose->is_new);
  for (const float unknown : {std::numeric_limits<float>::quiet_NaN(), -0.25F}) {
    message.covariance[0] = unknown;
    ASSERT_TRUE(read(message));
    EXPECT_EQ(read(message)->position_variance_m2.x(), 0.0) << "not known";
  }
}

// Would catch one reason for all refusals, and a zero that hides behind the quaternion.
TEST(PoseReading, EachWrongFormatHasAReasonOfItsOwn) {
  const AttPosMocap good{.time_usec = 5, .q = {1.F, 0.F, 0.F, 0.F}, .x = 1.F};
  EXPECT_EQ(aside_of(good).fault, PoseFault::kNone);
  const auto with = [&](const auto& change) {
    AttPosMocap message = good;
    change(message);
    return aside_of(message).fault;
  };
  EXPECT_EQ(with([](auto& m) { m.q = {}, m.x = 0.F; }), PoseFault::kZeros);
  EXPECT_EQ(with([](auto& m) { m.q = {}; }), PoseFault::kQuaternion);
  EXPECT_EQ(with([](auto& m) { m.x = std::nanf(""); }), PoseFault::kNotFinite);
  EXPECT_EQ(with([](auto& m) { m.z = -1500.F; }), PoseFault::kMillimetres);
  EXPECT_EQ(with([](auto& m) { m.time_usec = 1700000000000000000U; }), PoseFault::kFastStamp);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (float VisionPositionEstimate::*angle :
       {&VisionPositionEstimate::roll, &VisionPositionEstimate::pitch, &VisionPositionEstimate::yaw}) {
    VisionPositionEstimate wrong{.usec = 5};
    wrong.*angle = 90.F;
    EXPECT_EQ(aside_of(wrong).fault, PoseFault::kDegrees);
    wrong.*angle = nan;
    EXPECT_EQ(aside_of(wrong).fault, PoseFault::kNotFinite);
  }
  EXPECT_EQ(aside_of(VisionPositionEstimate{.usec = 5, .roll = 6.2832F, .yaw = -6.2832F}).fault, PoseFault::kNone);
  EXPECT_EQ(aside_of(Odometry{.time_usec = 5, .q = {1.F, 0.F, 0.F, 0.F}, .frame_id = 4}).fault, PoseFault::kFrame);
  // MAVLink: -1 failed, 0 unknown, 1 to 100 per cent.
  for (const auto& [quality, fault] :
       {std::pair{-1, PoseFault::kQuality}, {0, PoseFault::kNone}, {1, PoseFault::kNone}}) {
    const Odometry rated{
        .time_usec = 5, .q = {1.F, 0.F, 0.F, 0.F}, .frame_id = 20, .quality = static_cast<std::int8_t>(quality)};
    EXPECT_EQ(aside_of(rated).fault, fault) << quality;
  }
  for (const PoseFaultText& text : kPoseFaultTexts) {
    EXPECT_FALSE(text.name.empty());
    EXPECT_EQ(std::count_if(kPoseFaultTexts.begin(), kPoseFaultTexts.end(),
                            [&](const PoseFaultText& other) { return other.sentence == text.sentence; }),
              1)
        << text.name;
  }
}

// Catches an up that is taken in NED and FRD, or that depends on the heading.
TEST(PoseReading, TheUpOfThePoseIsInOurBody) {
  for (const float heading_rad : {0.F, 1.F, -2.5F}) {
    const PoseAside right_down = aside_of(VisionPositionEstimate{.usec = 5, .roll = 0.3F, .yaw = heading_rad});
    EXPECT_NEAR(core::up_in_body(right_down.flu_in_nwu).y(), std::sin(0.3F), 1e-6F) << "the left side points up";
    EXPECT_NEAR(core::up_in_body(right_down.flu_in_nwu).z(), std::cos(0.3F), 1e-6F);
    const PoseAside nose_up = aside_of(VisionPositionEstimate{.usec = 5, .pitch = 0.2F, .yaw = heading_rad});
    EXPECT_NEAR(core::up_in_body(nose_up.flu_in_nwu).x(), std::sin(0.2F), 1e-6F) << "the nose points up";
  }
  const float half = 0.4F;  // x y z w in place of w x y z, at a heading of 0.8 rad
  const PoseAside order = aside_of(AttPosMocap{.time_usec = 5, .q = {0.F, 0.F, std::sin(half), std::cos(half)}});
  EXPECT_NEAR(std::acos(core::up_in_body(order.flu_in_nwu).z()), 0.8F, 1e-5F) << "tilted by the heading";
}

}  // namespace
}  // namespace m100::link
