// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/dji/commands.h"
#include "protocol/dji/command_decoder.h"

#include <gtest/gtest.h>

#include <limits>

namespace m100::protocol {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

struct MovementCase {
  const char* name;
  Movement movement;
  core::Status status;
};

class MovementLimits : public ::testing::TestWithParam<MovementCase> {};

// What has no limit, values that are not numbers, and modes that do not exist. The numbers of the ranges are in
// limits_test.cpp.
TEST_P(MovementLimits, AreHeldByTheEncoder) {
  RecordProperty("promise", "R5");
  EXPECT_EQ(encode(GetParam().movement).status(), GetParam().status);
}

constexpr auto kOk = core::Status::kOk;
constexpr auto kOutOfRange = core::Status::kOutOfRange;
constexpr auto kInvalid = core::Status::kInvalidArgument;

INSTANTIATE_TEST_SUITE_P(Table, MovementLimits,
                         ::testing::Values(MovementCase{"OffsetHasNoLimit", {0x88, 500.F, -500.F, 0.F, 0.F}, kOk},
                                           MovementCase{"RollIsNoNumber", {0x0A, kNaN, 0.F, 0.F, 0.F}, kOutOfRange},
                                           MovementCase{
                                               "OffsetIsInfinite", {0x88, kInfinity, 0.F, 0.F, 0.F}, kOutOfRange},
                                           MovementCase{"HeightIsNoNumber", {0x18, 0.F, 0.F, kNaN, 0.F}, kOutOfRange},
                                           MovementCase{"YawIsNoNumber", {0x0A, 0.F, 0.F, 0.F, kNaN}, kOutOfRange},
                                           MovementCase{"ThrustWithSpeed", {0x6A, 0.F, 0.F, 50.F, 0.F}, kInvalid},
                                           MovementCase{"HorizontalModeFour", {0xC0, 0.F, 0.F, 0.F, 0.F}, kInvalid},
                                           MovementCase{"VerticalModeFour", {0x30, 0.F, 0.F, 0.F, 0.F}, kInvalid},
                                           MovementCase{"FrameThree", {0x04, 0.F, 0.F, 0.F, 0.F}, kInvalid}),
                         [](const auto& tested) { return tested.param.name; });

// Exactly the fourteen combinations that DJI allows, times frame and stability.
TEST(MovementMode, KnowsExactlyTheAllowedFlags) {
  std::size_t allowed = 0;
  for (unsigned flag = 0; flag < 256; ++flag) {
    const auto mode = movement_mode(static_cast<std::uint8_t>(flag));
    allowed += mode ? 1U : 0U;
    if (mode) {
      EXPECT_EQ(movement_flag(*mode), flag);
    }
  }
  EXPECT_EQ(allowed, 14U * 2U * 2U);
}

// Yaw comes last; the 2015 document swaps it with z.
TEST(Movement, PutsVerticalBeforeYaw) {
  const auto value = encode(Movement{.flag = 0x0A, .x = 1.F, .y = 2.F, .z = 3.F, .yaw = 4.F});
  ASSERT_TRUE(value);
  ASSERT_EQ(value->size(), 17U);
  EXPECT_EQ(load<float>(value->bytes().data() + 9), 3.F);
  EXPECT_EQ(load<float>(value->bytes().data() + 13), 4.F);
}

TEST(VirtualRc, NoChannelLeavesTheTravelOfAStick) {
  RecordProperty("promise", "R5");
  VirtualRcData data;
  data.channels.fill(kStickCentre_counts);
  EXPECT_TRUE(encode(data));
  for (std::size_t channel = 0; channel < data.channels.size(); ++channel) {
    for (const std::uint32_t bad : {0U, kStickLow_counts - 1, kStickHigh_counts + 1, 0xFFFFFFFFU}) {
      VirtualRcData wrong = data;
      wrong.channels[channel] = bad;
      EXPECT_EQ(encode(wrong).status(), core::Status::kOutOfRange) << channel << ' ' << bad;
    }
  }
}

// DJI's SDK never initialises the reserved bits, so a receiver must ignore them.
TEST(VirtualRc, SwitchIsReadPastReservedBits) {
  const std::array<std::byte, 1> value{std::byte{0xFD}};
  const auto command = decode_command(ids::kVirtualRcSwitch, value);
  ASSERT_TRUE(command);
  const auto* const to = std::get_if<VirtualRcSwitch>(&*command);
  ASSERT_NE(to, nullptr);
  EXPECT_TRUE(to->on);
  EXPECT_FALSE(to->fall_back_to_rc);
}

// SDK 3.3.0 to 4.1.0 sends stick data under the id of the switch; the length distinguishes them.
TEST(VirtualRc, DataUnderTheIdOfTheSwitchIsKnownByItsLength) {
  const std::array<std::byte, 64> value{std::byte{1}};
  const auto command = decode_command(ids::kVirtualRcSwitch, value);
  ASSERT_TRUE(command);
  const auto* const data = std::get_if<VirtualRcData>(&*command);
  ASSERT_NE(data, nullptr);
  EXPECT_TRUE(data->under_switch_id);
  EXPECT_EQ(decode_command(ids::kVirtualRcSwitch, std::span(value).first(2)).status(), kInvalid);
}

// Every command with every size: only the sizes of the catalogue are accepted.
TEST(DecodeCommand, RefusesEveryWrongSize) {
  const std::vector<std::byte> bytes(200, std::byte{1});
  for (const MessageInfo& info : kCatalogue) {
    for (std::size_t size = 0; size <= bytes.size(); ++size) {
      const bool fits = size >= info.min_value_bytes && size <= info.max_value_bytes;
      const auto command = decode_command(info.id, std::span(bytes).first(size));
      if (!fits || info.direction == Direction::kFromController) {
        EXPECT_FALSE(command) << info.name << ' ' << size;
      }
    }
  }
}

TEST(DecodeCommand, RefusesCodesThatDoNotExist) {
  const std::array<std::byte, 2> two{std::byte{2}, std::byte{2}};
  EXPECT_FALSE(decode_command(ids::kControlRequest, std::span(two).first(1)));
  EXPECT_FALSE(decode_command(ids::kMotors, std::span(two).first(1)));
  EXPECT_FALSE(decode_command(ids::kTask, two));
  EXPECT_FALSE(decode_command({0x07, 0x07}, two));
}

// The SDK replaces unknown rates by "leave as it is", and our decoder does the same.
TEST(TelemetryFrequency, ClampsUnknownRatesAndSendsEveryPlace) {
  std::array<std::byte, 16> value{};
  value[3] = std::byte{9};
  const auto command = decode_command(ids::kTelemetryFrequency, value);
  ASSERT_TRUE(command);
  EXPECT_EQ(std::get<TelemetryFrequency>(*command).rates[3], Rate::kAsItIs);
  TelemetryFrequency all;
  all.rates.fill(Rate::k100Hz);
  const auto encoded = encode(all);
  ASSERT_TRUE(encoded);
  EXPECT_EQ(encoded->bytes()[11], std::byte{4});
  EXPECT_EQ(encoded->bytes()[13], std::byte{4}) << "the control item of an N3";
  all.rates[0] = static_cast<Rate>(6);
  EXPECT_EQ(encode(all).status(), kOutOfRange);
}

}  // namespace
}  // namespace m100::protocol
