// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/dji/telemetry.h"

#include <gtest/gtest.h>

#include <cstring>
#include <vector>

namespace m100::protocol {
namespace {

/// Every byte of every item is different, so that a swapped or shifted item shows.
std::vector<std::byte> package(std::uint16_t items) {
  std::vector<std::byte> value(telemetry_value_bytes(items));
  std::memcpy(value.data(), &items, sizeof(items));
  for (std::size_t i = 2; i < value.size(); ++i) {
    value[i] = static_cast<std::byte>((i * 37U + items) & 0x7FU);  // below 0x80: no accidental NaN
  }
  return value;
}

// All 4096 combinations of items, byte for byte.
TEST(Telemetry, EveryCombinationOfItemsComesBackAsItWent) {
  for (unsigned items = 0; items <= kAllTelemetryItems; ++items) {
    const std::vector<std::byte> value = package(static_cast<std::uint16_t>(items));
    Telemetry telemetry;
    ASSERT_EQ(decode_telemetry(value, telemetry), core::Status::kOk) << items;
    const Value again = encode(telemetry);
    ASSERT_EQ(std::vector<std::byte>(again.bytes().begin(), again.bytes().end()), value) << items;
  }
}

// DJI's decoder reads the CRC as data when a package is short, and an A3 package has other sizes.
TEST(Telemetry, RefusesEverySizeThatDoesNotFitTheFlags) {
  for (const std::uint16_t items : {std::uint16_t{0}, std::uint16_t{1}, std::uint16_t{0x0A5}, kAllTelemetryItems}) {
    std::vector<std::byte> value = package(items);
    const std::size_t good = value.size();
    value.resize(good + 40);
    for (std::size_t size = 0; size < value.size(); ++size) {
      Telemetry telemetry;
      telemetry.battery_percent = 77;
      const core::Status status = decode_telemetry(std::span(value).first(size), telemetry);
      EXPECT_EQ(status == core::Status::kOk, size == good) << items << ' ' << size;
      if (size != good) {
        EXPECT_EQ(telemetry.battery_percent, 77) << "a refused package must change nothing";
      }
    }
  }
}

TEST(Telemetry, ItemsThatAreNotThereKeepTheirValues) {
  Telemetry telemetry;
  ASSERT_EQ(decode_telemetry(package(kAllTelemetryItems), telemetry), core::Status::kOk);
  const Telemetry::Rc before = telemetry.rc;
  ASSERT_EQ(decode_telemetry(package(static_cast<std::uint16_t>(TelemetryItem::kBattery)), telemetry),
            core::Status::kOk);
  EXPECT_TRUE(telemetry.has(TelemetryItem::kBattery));
  EXPECT_FALSE(telemetry.has(TelemetryItem::kRc));
  EXPECT_EQ(telemetry.rc.mode, before.mode);
}

// The offsets in the protocol description, with all items: 2, 11, 27, 39, 52, 64, 89, 95, 107, 120, 121, 122.
TEST(Telemetry, ItemsStandWhereTheDescriptionPutsThem) {
  std::vector<std::byte> value(124);
  const std::uint16_t items = kAllTelemetryItems;
  std::memcpy(value.data(), &items, 2);
  const auto put = [&](std::size_t at, auto number) { std::memcpy(value.data() + at, &number, sizeof(number)); };
  put(2, std::uint32_t{400});
  put(11, 0.5F);
  put(27, 1.5F);
  put(39 + 8, -2.5F);
  put(52 + 4, 3.5F);
  put(64, 0.75);
  put(64 + 8, -0.25);
  put(89 + 2, std::int16_t{-7});
  put(95 + 8, kRcModeF);
  put(107 + 4, -45.F);
  put(120, std::uint8_t{3});
  put(121, std::uint8_t{66});
  put(122, std::uint8_t{14});
  put(123, std::uint8_t{0x1A});
  Telemetry telemetry;
  ASSERT_EQ(decode_telemetry(value, telemetry), core::Status::kOk);
  EXPECT_EQ(telemetry.time.ticks, 400U);
  EXPECT_EQ(telemetry.attitude[0], 0.5F);
  EXPECT_EQ(telemetry.acceleration[0], 1.5F);
  EXPECT_EQ(telemetry.velocity_ned_m_s[2], -2.5F);
  EXPECT_EQ(telemetry.angular_velocity_frd_rad_s[1], 3.5F);
  EXPECT_EQ(telemetry.position.latitude_rad, 0.75);
  EXPECT_EQ(telemetry.position.longitude_rad, -0.25);
  EXPECT_EQ(telemetry.magnetometer[1], -7);
  EXPECT_EQ(telemetry.rc.mode, kRcModeF);
  EXPECT_EQ(telemetry.gimbal.pitch_deg, -45.F);
  EXPECT_EQ(telemetry.flight_status, FlightStatus::kInAir);
  EXPECT_EQ(telemetry.battery_percent, 66);
  EXPECT_EQ(telemetry.control.mode, 14);
  EXPECT_EQ(telemetry.control.device(), ControlDevice::kOnboardComputer);
  EXPECT_TRUE(telemetry.control.virtual_rc_on());
}

}  // namespace
}  // namespace m100::protocol
