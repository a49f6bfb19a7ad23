// SPDX-License-Identifier: BSD-3-Clause
// Which controllers' telemetry is decoded, and which controllers are refused by name. The sizes and bits of protocol,
// section 8, are written out by hand.
#include "protocol/dji/telemetry_layout.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <vector>

namespace m100::protocol {
namespace {

struct Controller {
  const char* name;
  const char* text;
  TelemetryLayout layout;
};
class Layout : public ::testing::TestWithParam<Controller> {};
INSTANTIATE_TEST_SUITE_P(
    Telemetry, Layout,
    ::testing::Values(Controller{"M100", "SDK-v1.0 BETA M100-03.01.01.00", TelemetryLayout::kM100},
                      Controller{"OldM100", "SDK-v1.0 BETA M100-02.03.10.00", TelemetryLayout::kOldM100},
                      Controller{"A3", "SDK-v1.0 BETA A3-03.01.100.00", TelemetryLayout::kFamily},
                      Controller{"N3", "SDK-v1.0 BETA N3-03.02.36.02", TelemetryLayout::kFamily},
                      Controller{"M600Pro", "SDK-v1.0 BETA M600PRO-03.02.41.05", TelemetryLayout::kFamily},
                      Controller{"LaterA3", "SDK-v1.0 BETA A3-03.03.08.10", TelemetryLayout::kLaterFamily},
                      Controller{"A3BeforeTheSdk", "SDK-v1.0 BETA A3-01.05.00.00", TelemetryLayout::kUnknown},
                      Controller{"M210", "SDK-v1.0 BETA M210-03.04.03.37", TelemetryLayout::kUnknown},
                      Controller{"Nonsense", "hello", TelemetryLayout::kUnknown},
                      Controller{"Empty", "", TelemetryLayout::kUnknown}),
    [](const auto& tested) { return tested.param.name; });

TEST_P(Layout, IsKnownFromTheVersionAnswer) {
  VersionAnswer answer;
  const std::string text = GetParam().text;
  std::copy(text.begin(), text.end(), answer.version_name.begin());
  EXPECT_EQ(name(telemetry_layout(answer)), name(GetParam().layout));
  EXPECT_EQ(remedy(GetParam().layout).empty(), is_decoded(GetParam().layout)) << "refused by name, or decoded";
}

template <typename T>
void put(std::vector<std::byte>& bytes, T value) {
  const std::size_t at = bytes.size();
  bytes.resize(at + sizeof value);
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

/// An A3 package with all 14 items: 2 + 198 bytes. The comments give the size of each item.
std::vector<std::byte> whole_package() {
  std::vector<std::byte> bytes;
  put<std::uint16_t>(bytes, 0x3FFF);
  put<std::uint32_t>(bytes, 4000);  // time: 9
  put<std::uint32_t>(bytes, 77);
  put<std::uint8_t>(bytes, 1);
  for (const float q : {0.5F, -0.5F, 0.25F, 0.75F}) {
    put(bytes, q);  // 16
  }
  for (const float a : {1.F, 2.F, 3.F}) {
    put(bytes, a);  // 12
  }
  for (const float v : {4.F, 5.F, 6.F}) {
    put(bytes, v);
  }
  put<std::uint8_t>(bytes, 7);  // 13
  for (const float w : {8.F, 9.F, 10.F}) {
    put(bytes, w);  // 12
  }
  put(bytes, 0.826);  // 25
  put(bytes, 0.149);
  put(bytes, 408.F);
  put(bytes, 1.5F);
  put<std::uint8_t>(bytes, 4);
  put<std::uint32_t>(bytes, 20161114);  // GPS detail: 32
  put<std::uint32_t>(bytes, 123456);
  put<std::int32_t>(bytes, 85417000);
  put<std::int32_t>(bytes, 473769000);
  put<std::int32_t>(bytes, 409500);
  for (const float v : {11.F, 12.F, 13.F}) {
    put(bytes, v);
  }
  put<std::uint32_t>(bytes, 20161115);  // RTK: 44
  put<std::uint32_t>(bytes, 123457);
  put(bytes, 8.5417);
  put(bytes, 47.3769);
  put(bytes, 409.25F);
  for (const float v : {14.F, 15.F, 16.F}) {
    put(bytes, v);
  }
  put<std::int16_t>(bytes, -90);
  put<std::uint8_t>(bytes, 50);
  put<std::uint8_t>(bytes, 51);
  for (const int m : {100, -200, 300}) {
    put(bytes, static_cast<std::int16_t>(m));  // 6
  }
  for (const int rc : {1000, -2000, 3000, -4000, 8000, -4545}) {
    put(bytes, static_cast<std::int16_t>(rc));  // 12
  }
  for (const float angle : {17.F, 18.F, 19.F}) {
    put(bytes, angle);
  }
  put<std::uint8_t>(bytes, 5);   // gimbal: 13
  put<std::uint8_t>(bytes, 3);   // status
  put<std::uint8_t>(bytes, 88);  // battery
  put<std::uint8_t>(bytes, 2);   // control: 2
  put<std::uint8_t>(bytes, 0x12);
  return bytes;
}

TEST(FamilyTelemetry, EveryItemIsFoundInItsPlace) {
  const std::vector<std::byte> package = whole_package();
  ASSERT_EQ(package.size(), 2U + 198U);
  Telemetry telemetry;
  FamilyItems more;
  ASSERT_EQ(decode_family_telemetry(package, telemetry, more), core::Status::kOk);
  EXPECT_EQ(telemetry.items, kAllTelemetryItems);
  EXPECT_EQ(telemetry.time.ticks, 4000U);
  EXPECT_EQ(telemetry.attitude[3], 0.75F);
  EXPECT_EQ(telemetry.position.height_m, 1.5F);
  EXPECT_EQ(telemetry.magnetometer[1], -200);
  EXPECT_EQ(telemetry.rc.mode, kRcModeF);
  EXPECT_EQ(telemetry.rc.gear, -4545);
  EXPECT_EQ(telemetry.gimbal.yaw_deg, 19.F);
  EXPECT_EQ(telemetry.flight_status, FlightStatus::kInAir);
  EXPECT_EQ(telemetry.battery_percent, 88);
  EXPECT_EQ(telemetry.control.mode, 2);
  EXPECT_EQ(telemetry.control.device(), ControlDevice::kOnboardComputer);
  EXPECT_TRUE(telemetry.control.virtual_rc_on());
  EXPECT_TRUE(more.has_gps_detail && more.has_rtk);
  EXPECT_EQ(more.gps_detail.latitude_1e7_deg, 473769000);
  EXPECT_EQ(more.gps_detail.velocity_ned_cm_s[2], 13.F);
  EXPECT_EQ(more.rtk.latitude_deg, 47.3769);
  EXPECT_EQ(more.rtk.yaw, -90);
  EXPECT_EQ(more.rtk.yaw_flag, 51);
}

// Decoded as an M100's, the numbers would be wrong: a status would become an RC item, an RC item a gimbal.
TEST(FamilyTelemetry, IsNeverTakenForAnM100s) {
  constexpr std::uint16_t kRcAndControl = (1U << 9U) | (1U << 13U);
  const std::vector<std::byte> whole = whole_package();
  std::vector<std::byte> package;
  put<std::uint16_t>(package, kRcAndControl);
  package.insert(package.end(), whole.begin() + 171, whole.begin() + 183);  // RC
  package.insert(package.end(), whole.end() - 2, whole.end());              // control
  Telemetry telemetry;
  FamilyItems more;
  EXPECT_EQ(decode_telemetry(package, telemetry), core::Status::kInvalidArgument);
  EXPECT_EQ(decode_telemetry(whole, telemetry), core::Status::kInvalidArgument);
  ASSERT_EQ(decode_family_telemetry(package, telemetry, more), core::Status::kOk);
  EXPECT_TRUE(telemetry.has(TelemetryItem::kRc) && telemetry.has(TelemetryItem::kControl));
  EXPECT_FALSE(telemetry.has(TelemetryItem::kFlightStatus));
  EXPECT_EQ(telemetry.rc.roll, 1000);
  EXPECT_EQ(telemetry.control.bits, 0x12);
  EXPECT_FALSE(more.has_gps_detail || more.has_rtk);
}

TEST(FamilyTelemetry, RefusesEveryOtherSizeAndChangesNothing) {
  std::vector<std::byte> package = whole_package();
  const std::size_t good = package.size();
  package.resize(good + 20);
  for (std::size_t size = 0; size < package.size(); ++size) {
    Telemetry telemetry;
    FamilyItems more;
    telemetry.battery_percent = 77;
    const core::Status status = decode_family_telemetry(std::span(package).first(size), telemetry, more);
    EXPECT_EQ(status == core::Status::kOk, size == good) << size;
    EXPECT_EQ(telemetry.battery_percent, size == good ? 88 : 77) << size;
  }
}

TEST(FamilyTelemetry, RatesAreAskedForInItsOwnOrder) {
  const auto places = rate_places(TelemetryLayout::kFamily);
  EXPECT_EQ(places[5], 5) << "position";
  EXPECT_EQ(places[7], 9) << "RC";
  EXPECT_EQ(places[11], 13) << "control";
  EXPECT_EQ(rate_places(TelemetryLayout::kM100)[11], 11);
}

}  // namespace
}  // namespace m100::protocol
