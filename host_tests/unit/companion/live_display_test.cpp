// SPDX-License-Identifier: BSD-3-Clause
// Live display of a flight: one JSON object per state, one status line, and no receiver unless one is given.
#include "firmware/companion/operator/live_display.h"
#include "firmware/companion/files/text/json.h"
#include "firmware/companion/ground_station/telemetry_stream.h"

#include <gtest/gtest.h>

#include <arpa/inet.h>
#include <malloc.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "firmware/companion/subcommands.h"

namespace m100::companion {
namespace {

using namespace std::chrono_literals;

app::TickRecord<double> flying() {
  app::TickRecord<double> record;
  record.now = core::TimePoint(12340ms);
  record.supervised.failsafe_state = safety::FailsafeState::kNominal;
  record.authority.in_control = true;
  record.estimate.x.position_m = 1.0;
  record.estimate.y.position_m = -2.0;
  record.estimate.height_m = 1.5;
  record.course_w_m = {1.03, -2.0, 1.54};
  record.seen.pose_latency = {.min_latency = 21ms, .jitter = 4ms};
  record.poses.poses = 1234;
  record.health.telemetry_rate_hz = 100.0;
  record.health.packages = 1;
  record.health.telemetry_age = 3ms;
  record.seen.consistency.vibration = {.rms_m_s2 = 0.03, .peak_m_s2 = 0.09};
  return record;
}

TEST(LiveDisplay, AStateIsOneObjectWithItsTime) {
  const Json json = Json::parse(json_of(flying()));
  EXPECT_EQ(json["timestamp"], 12.34);
  EXPECT_EQ(json["failsafe_state"], 1);
  EXPECT_EQ(json["position_m"]["y"], -2.0);
  EXPECT_EQ(json["reference_m"]["z"], 1.54);
  EXPECT_EQ(json["pose"]["taken"], 1234);
  EXPECT_EQ(json["link"]["telemetry_hz"], 100.0);
  EXPECT_EQ(json["vibration_m_s2"], 0.03);
  EXPECT_EQ(json["vibration_peak_m_s2"], 0.09);
  EXPECT_EQ(json["vibration_clipped"], 0.0);
  EXPECT_LT(json_of(flying()).size(), 1200U) << "one packet of a common network";
}

// JSON has no NaN; a receiver could not parse the object.
TEST(LiveDisplay, WhatIsNoNumberIsNull) {
  app::TickRecord<double> record = flying();
  record.estimate.yaw_rad = std::nan("");
  EXPECT_TRUE(Json::parse(json_of(record))["yaw_rad"].is_null());
}

TEST(LiveDisplay, TheLineSaysStatePlaceErrorPoseAndLink) {
  EXPECT_EQ(status_of(flying(), 0.0125),
            "nominal   1.00  -2.00  1.50 m, off 0.05 m, pose 21+4 ms, lost 1.2 %, link 100 Hz 3 ms, "
            "vibration 0.03, peak 0.09 m/s^2");
  app::TickRecord<double> waiting = flying();
  waiting.supervised.failsafe_state = safety::FailsafeState::kSilent;
  EXPECT_NE(status_of(waiting, 0.0).find("not flown"), std::string::npos);
  waiting.health.packages = 0;
  EXPECT_NE(status_of(waiting, 0.0).find("no telemetry"), std::string::npos);
  waiting.seen.consistency.vibration = {.rms_m_s2 = 40.0, .peak_m_s2 = 80.0, .clipped = 0.25};
  EXPECT_NE(status_of(waiting, 0.0).find("vibration 40.00, peak 80.00 m/s^2, clips 25 %"), std::string::npos);
  waiting.seen.consistency.vibration.rms_m_s2 = std::nan("");
  EXPECT_NE(status_of(waiting, 0.0).find("vibration not seen at this rate"), std::string::npos);
}

TEST(LiveDisplay, AReceiverIsAnAddressAndAPort) {
  EXPECT_FALSE(receiver_of("").has_value());
  const std::optional<sockaddr_in> receiver = receiver_of("127.0.0.1:9870");
  ASSERT_TRUE(receiver.has_value());
  EXPECT_EQ(ntohs(receiver->sin_port), 9870);
  EXPECT_EQ(ntohl(receiver->sin_addr.s_addr), INADDR_LOOPBACK);
  for (const char* const wrong : {"127.0.0.1", "localhost:9870", "127.0.0.1:0", "127.0.0.1:65536", "127.0.0.1:98x",
                                  "127.0.0.1:", ":9870", "1.2.3:9870", "127.0.0.1:123456789"}) {
    EXPECT_THROW((void)receiver_of(wrong), UsageError) << wrong;
  }
}

// Catches a thread with a malloc arena of its own, which takes 64 MB of address space: memory is locked, and the limit
// that doctor asks for does not leave room for it.
TEST(LiveDisplay, TheThreadThatSendsHasNoMemoryOfItsOwn) {
  std::optional<TelemetryStream> stream(std::in_place, LiveOptions{.to = "127.0.0.1:9"}, nullptr, std::nullopt);
  stream->publish(flying(), 0);
  stream.reset();
  char* text = nullptr;
  std::size_t size = 0;
  std::FILE* const report = open_memstream(&text, &size);
  ASSERT_EQ(malloc_info(0, report), 0);
  std::fclose(report);
  const std::string pools(text, size);
  std::free(text);
  EXPECT_NE(pools.find("<heap nr=\"0\">"), std::string::npos) << pools;
  EXPECT_EQ(pools.find("<heap nr=\"1\">"), std::string::npos) << pools;
}

}  // namespace
}  // namespace m100::companion
