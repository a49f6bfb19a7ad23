// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "host_tests/scenario/ground_station/ground_station_flight.h"
#include "protocol/mavlink/messages.h"

namespace m100::ground_station {

/// MAVROS 1.x on the board of m100: the poses of the emulated source as VISION_POSITION_ESTIMATE or ODOMETRY, a
/// heartbeat a second, ten time requests a second, answers to ours; unsigned, system 1, component 240.
struct MavrosTest : GroundStationFlight {
  static constexpr mavlink::Address kMavros{.system = 1, .component = 240};
  static constexpr std::int64_t kEpoch_us = 1'700'000'000'000'000;

  bool sends_odometry = false;
  std::uint8_t numbers = 0;
  std::uint64_t heartbeats = 0, time_questions = 0, time_answers = 0, poses = 0;
  double sent_time_s = -1.0;

  void SetUp() override {
    GroundStationFlight::SetUp();
    ground_station->sends_poses = false;
    ground_station->on_pose = [this](const mavlink::AttPosMocap& seen) { take(seen); };
  }
  std::string loopback_port() const { return "udp:127.0.0.1:" + ground_station->pose_port().substr(4); }

  std::int64_t clock_us() const { return kEpoch_us + std::llround(1e6 * ground_station->now_s()); }
  template <typename Message>
  void send(const Message& message, mavlink::Address from = kMavros) {
    ground_station->send_unauthorized(mavlink::encode(message, from, numbers++).bytes());
  }

  void take(const mavlink::AttPosMocap& seen) {
    truth = {static_cast<double>(seen.x), static_cast<double>(seen.y), static_cast<double>(seen.z)};
    ++poses;
    const auto stamp = static_cast<std::uint64_t>(clock_us());
    if (sends_odometry) {
      send(mavlink::Odometry{.time_usec = stamp,
                             .x = seen.x,
                             .y = seen.y,
                             .z = seen.z,
                             .q = seen.q,
                             .frame_id = 20,
                             .child_frame_id = 12});
    } else {
      const auto [w, x, y, z] = seen.q;
      send(mavlink::VisionPositionEstimate{.usec = stamp,
                                           .x = seen.x,
                                           .y = seen.y,
                                           .z = seen.z,
                                           .roll = std::atan2(2.F * (w * x + y * z), 1.F - 2.F * (x * x + y * y)),
                                           .pitch = std::asin(2.F * (w * y - z * x)),
                                           .yaw = std::atan2(2.F * (w * z + x * y), 1.F - 2.F * (y * y + z * z))});
    }
    if (poses % 100 == 0) {
      send(mavlink::Heartbeat{.type = 18, .autopilot = 8, .base_mode = 192, .system_status = 4, .mavlink_version = 3});
    }
    if (poses % 10 == 0) {
      send(mavlink::Timesync{.tc1 = 0, .ts1 = clock_us() * 1000});
    }
    listen();
  }

  void listen() {
    while (const std::optional<Packet> packet = ground_station->unauthorized().receive()) {
      mavlink::Parser parser;
      parser.consume(*packet, [this](const mavlink::FrameView& frame) {
        receive(frame);
        if (mavlink::is<mavlink::Heartbeat>(frame)) {
          ++heartbeats;
        } else if (mavlink::is<mavlink::Timesync>(frame)) {
          take(mavlink::decode<mavlink::Timesync>(frame));
        }
      });
    }
  }
  void take(const mavlink::Timesync& message) {
    if (message.tc1 == 0) {
      ++time_questions;
      send(mavlink::Timesync{.tc1 = clock_us() * 1000, .ts1 = message.ts1});
    } else {
      ++time_answers;
      EXPECT_LE(message.ts1, clock_us() * 1000) << "our own time must come back";
    }
  }

  bool start(const Words& more) {
    ground_station->start_autopilot(events);
    const Words words{"fly",   "--port", ground_station->port(), "--pose-port", loopback_port(), "--pose-from",
                      "1:240", "--json", result.string(),        "--log",       log.string(),    "--take-control",
                      "--once"};
    return ground_station->start(with(with(words, models()), more), errors);
  }
  void pass(double seconds) {
    (void)ground_station->run_until([] { return false; }, seconds);
  }
};

}  // namespace m100::ground_station
