// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <csignal>
#include <cstdint>
#include <map>
#include <optional>

#include "host_tests/scenario/program/program_fixture.h"
#include "host_tests/scenario/room/room.h"
#include "protocol/mavlink/messages.h"

namespace m100::room {

inline constexpr std::uint8_t kArmed = 128;
inline constexpr std::uint16_t kReturnHome = 20;
inline constexpr std::uint16_t kLand = 21;
inline constexpr std::uint16_t kTakeOff = 22;
inline constexpr std::uint16_t kGuidedEnable = 92;
inline constexpr std::uint16_t kMissionStart = 300;
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
                         Room::kSender, number);
}

/// m100 flown by a room over a network that loses, doubles and reorders packets.
struct RoomFlight : scenario::ProgramTest {
  std::unique_ptr<Room> room;
  Place truth;
  mavlink::LocalPositionNed position;
  std::uint8_t base_mode = 0;
  std::uint64_t attitudes = 0, estimates = 0;
  std::int8_t battery = -1;              // %, as in the message
  std::map<std::uint16_t, int> answers;  ///< by command
  std::vector<mavlink::MissionItemInt> mission;
  std::optional<int> carried_over;  ///< the result of the mission's transfer
  std::vector<int> reached;
  int mission_state = 0;
  std::map<std::string, float> parameters;
  std::string said;

  void SetUp() override {
    ProgramTest::SetUp();
    room = std::make_unique<Room>(folder, 2);
    room->network.lost = room->network.doubled = room->network.swapped = 0.05;
    room->on_pose = [this](const mavlink::AttPosMocap& seen) {
      truth = {static_cast<double>(seen.x), static_cast<double>(seen.y), static_cast<double>(seen.z)};
    };
    room->on_frame = [this](const mavlink::FrameView& frame) { hear(frame); };
  }
  void TearDown() override {
    room.reset();
    ProgramTest::TearDown();
  }

  void hear(const mavlink::FrameView& frame) {
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
    } else {
      hear_mission(frame);
    }
  }
  void hear_mission(const mavlink::FrameView& frame) {
    if (mavlink::is<mavlink::MissionRequestInt>(frame)) {
      const auto asked = mavlink::decode<mavlink::MissionRequestInt>(frame);
      EXPECT_EQ(asked.target_system, Room::kSender.system);
      (void)room->send(mavlink::encode(mission.at(asked.seq), Room::kSender, room->frames++));
    } else if (mavlink::is<mavlink::MissionAck>(frame)) {
      carried_over = mavlink::decode<mavlink::MissionAck>(frame).type;
    } else if (mavlink::is<mavlink::MissionItemReached>(frame)) {
      reached.push_back(mavlink::decode<mavlink::MissionItemReached>(frame).seq);
    } else if (mavlink::is<mavlink::MissionCurrent>(frame)) {
      mission_state = mavlink::decode<mavlink::MissionCurrent>(frame).mission_state;
    } else if (mavlink::is<mavlink::ParamValue>(frame)) {
      const auto value = mavlink::decode<mavlink::ParamValue>(frame);
      parameters[std::string(value.param_id.data(), strnlen(value.param_id.data(), value.param_id.size()))] =
          value.param_value;
    }
  }
  void adds(const Place& place, float radius_m = 0.F) {
    mission.push_back({.param2 = radius_m,
                       .param4 = std::nanf(""),
                       .x = static_cast<std::int32_t>(std::lround(place.x * 1e4)),
                       .y = static_cast<std::int32_t>(std::lround(place.y * 1e4)),
                       .z = static_cast<float>(place.z),
                       .seq = static_cast<std::uint16_t>(mission.size()),
                       .command = 16,
                       .target_system = 1,
                       .frame = 1,
                       .autocontinue = 1});
  }
  /// Transfers the mission; repeats, because packets are lost.
  bool carries_over() {
    carried_over.reset();
    int rounds = 0;
    return hears([&] {
      if (!carried_over && rounds++ % 200 == 0) {
        (void)room->send(mavlink::encode(
            mavlink::MissionCount{.count = static_cast<std::uint16_t>(mission.size()), .target_system = 1},
            Room::kSender, room->frames++));
      }
      return carried_over.has_value();
    });
  }
  bool starts(std::vector<std::string> more = {}, const std::vector<std::string>& of_autopilot = {}) {
    room->start_autopilot(events, of_autopilot);
    std::vector<std::string> words = fly_words(*room, key_file(Room::key_text()).string());
    words.insert(words.end(), {"--log", log.string()});
    words.insert(words.end(), more.begin(), more.end());
    return room->start(words, errors);
  }
  /// Runs until the room has received what it waits for; m100 sends from a thread that runs in real time.
  bool hears(const std::function<bool()>& condition) {
    constexpr int kRounds = 3000;
    for (int round = 0; round < kRounds && !condition(); ++round) {
      (void)room->run_until([] { return false; }, 0.05);
      usleep(5000);
    }
    return condition();
  }
  /// Sends a command until it is answered; repeats, because packets are lost.
  bool orders(std::uint16_t command, float param1, float param7 = 0.F) {
    answers.erase(command);
    return hears([&] {
      if (answers.count(command) == 0) {
        (void)room->send(mavlink::encode(
            mavlink::CommandLong{.param1 = param1, .param7 = param7, .command = command, .target_system = 1},
            Room::kSender, room->frames++));
      }
      return answers.count(command) > 0;
    });
  }
  void flies_to(const Place& goal) {
    for (int second = 0; second < 12; ++second) {
      (void)room->send(goal_frame(goal, room->frames++));  // repeating a goal has no further effect
      (void)room->run_until([] { return false; }, 1.0);
    }
    EXPECT_LT(distance(truth, goal), kAtCorner_m) << "at " << truth.x << " " << truth.y << " " << truth.z;
  }
};

}  // namespace m100::room
