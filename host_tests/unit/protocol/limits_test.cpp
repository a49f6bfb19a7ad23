// SPDX-License-Identifier: BSD-3-Clause
// Every limit of a sent value, at its last valid and first invalid number; the defaults of the messages; and the
// numbers of the catalogue, written out a second time (protocol/README.md).
#include <gtest/gtest.h>

#include <array>
#include <span>
#include <string>
#include <vector>

#include "protocol/dji/commands.h"
#include "protocol/dji/pushes.h"
#include "protocol/dji/session.h"

namespace m100::protocol {
namespace {

using std::chrono::milliseconds;

/// A number of a command and its range.
struct Edge {
  const char* name;
  bool (*fits)(double);
  double low, below;
  double high, above;
};

bool movement_fits(const Movement& movement) { return encode(movement).has_value(); }
float narrow(double value) { return static_cast<float>(value); }
std::int16_t deci(double value) { return static_cast<std::int16_t>(value); }

const Edge kEdges[] = {
    {"TiltX", [](double v) { return movement_fits({.flag = 0x0A, .x = narrow(v)}); }, -30., -30.001, 30., 30.001},
    {"TiltY", [](double v) { return movement_fits({.flag = 0x0A, .y = narrow(v)}); }, -30., -30.001, 30., 30.001},
    {"SpeedX", [](double v) { return movement_fits({.flag = 0x48, .x = narrow(v)}); }, -10., -10.001, 10., 10.001},
    {"SpeedY", [](double v) { return movement_fits({.flag = 0x48, .y = narrow(v)}); }, -10., -10.001, 10., 10.001},
    {"Climb", [](double v) { return movement_fits({.flag = 0x0A, .z = narrow(v)}); }, -4., -4.001, 4., 4.001},
    {"Height", [](double v) { return movement_fits({.flag = 0x18, .z = narrow(v)}); }, 0., -1e-6, 3e38, 3.4e38},
    {"Thrust", [](double v) { return movement_fits({.flag = 0x2A, .z = narrow(v)}); }, 10., 9.999, 100., 100.001},
    {"Offset", [](double v) { return movement_fits({.flag = 0x88, .x = narrow(v)}); }, -3e38, -3.4e38, 3e38, 3.4e38},
    {"YawRate", [](double v) { return movement_fits({.flag = 0x0A, .yaw = narrow(v)}); }, -100., -100.01, 100., 100.01},
    {"Yaw", [](double v) { return movement_fits({.flag = 0x02, .yaw = narrow(v)}); }, -180., -180.02, 180., 180.02},
    {"GimbalYaw", [](double v) { return encode(GimbalAngle{.yaw_decideg = deci(v)}).has_value(); }, -3200, -3201, 3200,
     3201},
    {"GimbalRoll", [](double v) { return encode(GimbalAngle{.roll_decideg = deci(v)}).has_value(); }, -350, -351, 350,
     351},
    {"GimbalPitch", [](double v) { return encode(GimbalAngle{.pitch_decideg = deci(v)}).has_value(); }, -900, -901, 300,
     301},
    {"GimbalYawRate", [](double v) { return encode(GimbalRate{.yaw_decideg_s = deci(v)}).has_value(); }, -1800, -1801,
     1800, 1801},
    {"GimbalRollRate", [](double v) { return encode(GimbalRate{.roll_decideg_s = deci(v)}).has_value(); }, -1800, -1801,
     1800, 1801},
    {"GimbalPitchRate", [](double v) { return encode(GimbalRate{.pitch_decideg_s = deci(v)}).has_value(); }, -1800,
     -1801, 1800, 1801},
    {"Stick",
     [](double v) {
       VirtualRcData data;
       data.channels.fill(1024);
       data.channels[7] = static_cast<std::uint32_t>(v);
       return encode(data).has_value();
     },
     364, 363, 1684, 1685},
    {"BytesToTheMobile",
     [](double v) {
       ToMobile message;
       message.data.size = static_cast<std::uint8_t>(v);
       return encode(message).has_value();
     },
     0, 255, 100, 101},
    {"BytesFromTheMobile",
     [](double v) {
       FromMobile message;
       message.data.size = static_cast<std::uint8_t>(v);
       return encode(message).has_value();
     },
     1, 0, 100, 101},
};

class Limit : public ::testing::TestWithParam<Edge> {};

TEST_P(Limit, TakesItsLastNumberAndNotTheNext) {
  RecordProperty("promise", "R5");
  const Edge& edge = GetParam();
  EXPECT_TRUE(edge.fits(edge.low)) << edge.low;
  EXPECT_FALSE(edge.fits(edge.below)) << edge.below;
  EXPECT_TRUE(edge.fits(edge.high)) << edge.high;
  EXPECT_FALSE(edge.fits(edge.above)) << edge.above;
}
INSTANTIATE_TEST_SUITE_P(Protocol, Limit, ::testing::ValuesIn(kEdges),
                         [](const auto& tested) { return std::string(tested.param.name); });

std::vector<unsigned> numbers(std::span<const std::byte> bytes) {
  std::vector<unsigned> out;
  for (const std::byte value : bytes) {
    out.push_back(std::to_integer<unsigned>(value));
  }
  return out;
}
template <typename Command>
std::vector<unsigned> bytes_of_default() {
  return numbers(encode(Command{})->bytes());
}

// Would catch a wrong default: a gimbal that moves, a motor that starts, a fallback that is given up.
TEST(Defaults, AreWhatNobodyHasAskedFor) {
  EXPECT_EQ(bytes_of_default<VersionQuery>(), (std::vector<unsigned>{0}));
  std::vector<unsigned> activation(44, 0);
  activation[4] = 2;  // the level that DJI's SDK sends
  EXPECT_EQ(bytes_of_default<Activation>(), activation);
  EXPECT_EQ(bytes_of_default<TelemetryFrequency>(), std::vector<unsigned>(16, 0));
  EXPECT_TRUE(bytes_of_default<ToMobile>().empty());
  EXPECT_EQ(bytes_of_default<ControlRequest>(), (std::vector<unsigned>{1}));
  EXPECT_EQ(bytes_of_default<TaskRequest>(), (std::vector<unsigned>{0, 4}));
  EXPECT_EQ(bytes_of_default<TaskQuery>(), (std::vector<unsigned>{0}));
  EXPECT_EQ(bytes_of_default<MotorRequest>(), (std::vector<unsigned>{0}));
  EXPECT_EQ(bytes_of_default<Movement>(), std::vector<unsigned>(17, 0));
  EXPECT_EQ(bytes_of_default<GimbalRate>(), (std::vector<unsigned>{0, 0, 0, 0, 0, 0, 0x80}));
  EXPECT_EQ(bytes_of_default<GimbalAngle>(), (std::vector<unsigned>{0, 0, 0, 0, 0, 0, 1, 0}));
  EXPECT_EQ(bytes_of_default<CameraRequest>(), (std::vector<unsigned>{0}));
  EXPECT_EQ(id_of(CameraRequest{}), ids::kPhoto);
  EXPECT_EQ(bytes_of_default<SyncPulse>(), (std::vector<unsigned>{0, 0, 0, 0}));
  EXPECT_EQ(bytes_of_default<VirtualRcSwitch>(), (std::vector<unsigned>{2})) << "off, and falls back to the pilot";
  EXPECT_EQ(encode(VirtualRcData{}).status(), core::Status::kOutOfRange) << "no stick stands at nothing";
  EXPECT_FALSE(VirtualRcData{}.under_switch_id);
  EXPECT_EQ(bytes_of_default<ControlLost>(), (std::vector<unsigned>{4}));
  EXPECT_EQ(bytes_of_default<MissionStatus>(), std::vector<unsigned>(6, 0));
  EXPECT_EQ(bytes_of_default<WaypointEvent>(), std::vector<unsigned>(6, 0));
  EXPECT_EQ(movement_flag(MovementMode{}), 0x0A) << "angles, climb rate, yaw rate, in the body's heading";
}

TEST(Pushes, ThatNobodyKnowsAreRefused) {
  const std::array<std::byte, 6> value{};
  EXPECT_EQ(decode_push({.set = 0x07, .id = 0x07}, value).status(), core::Status::kInvalidArgument);
  EXPECT_EQ(decode_push(ids::kMissionStatus, std::span(value).first(5)).status(), core::Status::kInvalidArgument);
  EXPECT_TRUE(decode_push(ids::kMissionStatus, value));
}

TEST(Pushes, ComeBackAsTheyWereSent) {
  const auto again = [](const auto& push) {
    const auto value = encode(push);
    return *decode_push(id_of(push), value->bytes());
  };
  EXPECT_EQ(std::get<ControlLost>(again(ControlLost{7})).value, 7);
  const auto status = std::get<MissionStatus>(again(MissionStatus{3, {1, 2, 3, 4, 5}}));
  EXPECT_EQ(status.kind, 3);
  EXPECT_EQ(status.rest, (std::array<std::uint8_t, 5>{1, 2, 3, 4, 5}));
  const auto event = std::get<WaypointEvent>(again(WaypointEvent{2, {9, 8, 7, 6, 5}}));
  EXPECT_EQ(event.event, 2);
  EXPECT_EQ(event.rest, (std::array<std::uint8_t, 5>{9, 8, 7, 6, 5}));
  FromMobile sent;
  sent.data.bytes[0] = std::byte{42};
  sent.data.bytes[99] = std::byte{43};
  sent.data.size = 100;
  const auto mobile = std::get<FromMobile>(again(sent));
  EXPECT_EQ(numbers(mobile.data.view()), numbers(sent.data.view()));
  EXPECT_EQ(decode_push(ids::kTelemetry, std::vector<std::byte>(10)).status(), core::Status::kInvalidArgument);
  EXPECT_EQ(decode_push(ids::kFromMobile, std::vector<std::byte>(101)).status(), core::Status::kInvalidArgument);
}

struct CatalogueRow {
  MessageId id;
  const char* name;
  int least, most;
  Delivery delivery;
  int timeout_ms, transmissions;
};

// The protocol's table, written out a second time: its time-outs and retries decide how long an aircraft waits.
TEST(Catalogue, SaysWhatTheProtocolsTableSays) {
  constexpr auto kOnce = Delivery::kUnanswered;
  constexpr auto kSure = Delivery::kReliable;
  const CatalogueRow rows[] = {{ids::kVersionQuery, "version_query", 1, 1, kSure, 100, 3},
                               {ids::kActivation, "activate", 44, 44, kSure, 1000, 3},
                               {ids::kTelemetryFrequency, "set_broadcast_frequency", 16, 16, kSure, 100, 3},
                               {ids::kToMobile, "to_mobile", 0, 100, kSure, 500, 2},
                               {ids::kControlRequest, "control", 1, 1, kSure, 500, 2},
                               {ids::kTask, "task", 2, 2, kSure, 100, 3},
                               {ids::kTaskQuery, "task_query", 1, 1, kSure, 100, 3},
                               {ids::kMovement, "movement", 17, 17, kOnce, 0, 1},
                               {ids::kMotors, "motors", 1, 1, kSure, 100, 3},
                               {ids::kGimbalRate, "gimbal_rate", 7, 7, kOnce, 0, 1},
                               {ids::kGimbalAngle, "gimbal_angle", 8, 8, kOnce, 0, 1},
                               {ids::kPhoto, "photo", 1, 1, kOnce, 0, 1},
                               {ids::kVideoStart, "video_start", 1, 1, kOnce, 0, 1},
                               {ids::kVideoStop, "video_stop", 1, 1, kOnce, 0, 1},
                               {ids::kTelemetry, "telemetry", 2, 124, kOnce, 0, 1},
                               {ids::kControlLost, "lost_control", 1, 1, kOnce, 0, 1},
                               {ids::kFromMobile, "from_mobile", 1, 100, kOnce, 0, 1},
                               {ids::kMissionStatus, "mission_status", 6, 6, kOnce, 0, 1},
                               {ids::kWaypointEvent, "waypoint_event", 6, 6, kOnce, 0, 1},
                               {ids::kSyncPulse, "sync_frequency", 4, 6, kOnce, 0, 1},
                               {ids::kVirtualRcSwitch, "vrc_switch", 1, 64, kOnce, 0, 1},
                               {ids::kVirtualRcData, "vrc_data", 64, 64, kOnce, 0, 1}};
  ASSERT_EQ(std::size(rows), kCatalogue.size());
  for (const CatalogueRow& row : rows) {
    const MessageInfo* const info = find(row.id);
    ASSERT_NE(info, nullptr) << row.name;
    EXPECT_EQ(name(row.id), row.name);
    EXPECT_EQ(info->min_value_bytes, row.least) << row.name;
    EXPECT_EQ(info->max_value_bytes, row.most) << row.name;
    EXPECT_EQ(info->delivery, row.delivery) << row.name;
    const RequestOptions options = options_for(*info);
    EXPECT_EQ(options.timeout, milliseconds(row.timeout_ms)) << row.name;
    EXPECT_EQ(options.transmissions, row.transmissions) << row.name;
    EXPECT_EQ(options.cipher, nullptr);
  }
  EXPECT_EQ(find({0x07, 0x07}), nullptr);
  EXPECT_EQ(name({0x07, 0x07}), "unknown");
}

}  // namespace
}  // namespace m100::protocol
