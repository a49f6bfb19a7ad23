// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>
#include <map>
#include <optional>

#include "host_tests/scenario/ground_station/ground_station.h"
#include "host_tests/scenario/program/program_fixture.h"
#include "protocol/mavlink/messages.h"

namespace m100::ground_station {

inline constexpr std::uint8_t kArmed = 128;
inline constexpr std::uint16_t kReturnHome = 20;
inline constexpr std::uint16_t kLand = 21;
inline constexpr std::uint16_t kTakeOff = 22;
inline constexpr std::uint16_t kGuidedEnable = 92;
inline constexpr std::uint16_t kOnlyPosition = 0b110111111000;
/// Largest distance from a corner when the aircraft has come to rest there.
inline constexpr double kAtCorner_m = 0.25;

struct Place {
  double x = 0.0, y = 0.0, z = 0.0;  ///< NED
};
inline double distance(const Place& a, const Place& b) { return std::hypot(a.x - b.x, a.y - b.y, a.z - b.z); }

inline mavlink::Frame goal_frame(const Place& place, std::uint8_t number) {
  return mavlink::encode(mavlink::SetPositionTargetLocalNed{.x = static_cast<float>(place.x),
                                                            .y = static_cast<float>(place.y),
                                                            .z = static_cast<float>(place.z),
                                                            .type_mask = kOnlyPosition,
                                                            .target_system = 1,
                                                            .coordinate_frame = 1},
                         GroundStation::kSender, number);
}

/// m100 with a room, and the file of the room's key.
struct GroundStationTest : scenario::ProgramTest {
  std::unique_ptr<GroundStation> ground_station;
  std::string key;
  std::uint64_t seed = 2;

  void SetUp() override {
    ProgramTest::SetUp();
    ground_station = std::make_unique<GroundStation>(folder, seed);
    key = key_file(GroundStation::key_text()).string();
  }
  void TearDown() override { ground_station.reset(); }
};

/// m100 flown by a room over a network that loses, doubles and reorders packets.
struct GroundStationFlight : GroundStationTest {
  Place truth;
  mavlink::LocalPositionNed position;
  std::uint8_t base_mode = 0;
  std::uint64_t attitudes = 0, estimates = 0;
  std::int8_t battery = -1;              // %, as in the message
  std::map<std::uint16_t, int> answers;  ///< by command
  std::string said;

  void SetUp() override {
    GroundStationTest::SetUp();
    ground_station->network.lost = ground_station->network.doubled = ground_station->network.swapped = 0.05;
    ground_station->on_pose = [this](const mavlink::AttPosMocap& seen) {
      truth = {static_cast<double>(seen.x), static_cast<double>(seen.y), static_cast<double>(seen.z)};
    };
    ground_station->on_frame = [this](const mavlink::FrameView& frame) { receive(frame); };
  }

  void receive(const mavlink::FrameView& frame) {
    if (mavlink::is<mavlink::Heartbeat>(frame)) {
      base_mode = mavlink::decode<mavlink::Heartbeat>(frame).base_mode;
    } else if (mavlink::is<mavlink::LocalPositionNed>(frame)) {
      position = mavlink::decode<mavlink::LocalPositionNed>(frame);
    } else if (mavlink::is<mavlink::AttitudeQuaternion>(frame)) {
      ++attitudes;
    } else if (mavlink::is<mavlink::EstimatorStatus>(frame)) {
      ++estimates;
    } else if (mavlink::is<mavlink::BatteryStatus>(frame)) {
      battery = mavlink::decode<mavlink::BatteryStatus>(frame).battery_remaining;
    } else if (mavlink::is<mavlink::CommandAck>(frame)) {
      const auto answer = mavlink::decode<mavlink::CommandAck>(frame);
      answers[answer.command] = answer.result;
    } else if (mavlink::is<mavlink::StatusText>(frame)) {
      const auto text = mavlink::decode<mavlink::StatusText>(frame);
      said += std::string(text.text.data(), strnlen(text.text.data(), text.text.size()));
    }
  }
  bool start_flight(std::vector<std::string> more = {}, const std::vector<std::string>& of_autopilot = {}) {
    ground_station->start_autopilot(events, of_autopilot);
    more.insert(more.end(), {"--log", log.string()});
    return ground_station->start(with(fly_words(*ground_station, key), more), errors);
  }
  /// Runs until the room has received what it waits for; m100 sends from a thread that runs in real time.
  bool receive_until(const std::function<bool()>& condition) {
    constexpr int kRounds = 60000;  // of 5 ms: patience for a busy machine
    for (int round = 0; round < kRounds && !condition(); ++round) {
      (void)ground_station->run_until([] { return false; }, 0.05);
      usleep(5000);
    }
    return condition();
  }
  /// Sends a command until it is answered; repeats, because packets are lost.
  bool send_command(std::uint16_t command, float param1, float param7 = 0.F) {
    answers.erase(command);
    return receive_until([&] {
      if (answers.count(command) == 0) {
        (void)ground_station->send(mavlink::encode(
            mavlink::CommandLong{.param1 = param1, .param7 = param7, .command = command, .target_system = 1},
            GroundStation::kSender, ground_station->frames++));
      }
      return answers.count(command) > 0;
    });
  }
  void fly_to(const Place& goal) {
    for (int second = 0; second < 12; ++second) {
      (void)ground_station->send(goal_frame(goal, ground_station->frames++));  // repeating a goal has no further effect
      (void)ground_station->run_until([] { return false; }, 1.0);
    }
    EXPECT_LT(distance(truth, goal), kAtCorner_m) << "at " << truth.x << " " << truth.y << " " << truth.z;
  }
};

}  // namespace m100::ground_station
