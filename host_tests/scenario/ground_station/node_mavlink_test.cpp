// SPDX-License-Identifier: BSD-3-Clause
// An independent implementation of MAVLink controls m100: poses at 100 Hz, a square by goals, the state read back, over
// UDP, signed, with 5 % of the packets lost, doubled and reordered. Needs M100_NODE_MAVLINK, a folder of node modules
// with node-mavlink; without it the test is skipped with a message.
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "host_tests/scenario/ground_station/ground_station.h"
#include "host_tests/scenario/program/program_fixture.h"

namespace m100::ground_station {
namespace {

/// Runs node_ground_station.js: each line gets one line as an answer.
class NodeGroundStation {
 public:
  NodeGroundStation(const std::string& modules, const std::string& port, const std::string& key) {
    std::array<int, 2> to{}, from{};
    EXPECT_EQ(pipe2(to.data(), O_CLOEXEC), 0);
    EXPECT_EQ(pipe2(from.data(), O_CLOEXEC), 0);
    const auto hour_ahead_ms = (static_cast<std::int64_t>(::time(nullptr)) + 3600) * 1000;
    const Words words{M100_NODE_GROUND_STATION, modules, port, key, std::to_string(hour_ahead_ms)};
    node_ = std::make_unique<scenario::Process>("node", words, "", from[1], to[0]);
    ::close(to[0]);
    ::close(from[1]);
    to_ = to[1];
    from_ = fdopen(from[0], "r");
    EXPECT_EQ(line(), "ok") << "node-mavlink is not in " << modules;
  }
  ~NodeGroundStation() {
    ::close(to_);
    fclose(from_);
    (void)node_->wait();
  }
  NodeGroundStation(const NodeGroundStation&) = delete;
  NodeGroundStation& operator=(const NodeGroundStation&) = delete;

  std::string ask(const std::string& words) {
    const std::string all = words + "\n";
    EXPECT_EQ(write(to_, all.data(), all.size()), static_cast<ssize_t>(all.size()));
    return line();
  }
  Json state() { return Json::parse(ask("state")); }

 private:
  std::string line() {
    std::array<char, 1 << 16> text{};
    if (fgets(text.data(), static_cast<int>(text.size()), from_) == nullptr) {
      ADD_FAILURE() << "node has ended";
      return "{}";
    }
    std::string said(text.data());
    said.erase(said.find_last_not_of('\n') + 1);
    return said;
  }
  std::unique_ptr<scenario::Process> node_;
  int to_ = -1;
  FILE* from_ = nullptr;
};

std::string numbers(std::initializer_list<double> values) {
  std::string text;
  for (const double value : values) {
    std::array<char, 40> one{};
    std::snprintf(one.data(), one.size(), " %.9g", value);
    text += one.data();
  }
  return text;
}

struct NodeMavlink : scenario::ProgramTest {};

// Deviation: longer than a function may be, because it is one flight in its order.
TEST_F(NodeMavlink, FliesASquareByGoalsAndReadsTheStateBack) {
  const char* const modules = std::getenv("M100_NODE_MAVLINK");
  if (modules == nullptr) {
    GTEST_SKIP() << "M100_NODE_MAVLINK does not name a folder with node-mavlink";
  }
  signal(SIGPIPE, SIG_IGN);
  GroundStation ground_station(folder, 3);
  ground_station.sends_poses = false;
  NodeGroundStation node(modules, ground_station.pose_port().substr(4), GroundStation::key_text());
  std::array<double, 3> truth{};
  std::vector<Packet> forged;
  ground_station.on_pose = [&](const mavlink::AttPosMocap& seen) {
    truth = {static_cast<double>(seen.x), static_cast<double>(seen.y), static_cast<double>(seen.z)};
    (void)node.ask("time " + std::to_string(std::llround(1000.0 * ground_station.now_s())));
    EXPECT_EQ(
        node.ask("pose " + std::to_string(seen.time_usec) +
                 numbers({truth[0], truth[1], truth[2], static_cast<double>(seen.q[0]), static_cast<double>(seen.q[1]),
                          static_cast<double>(seen.q[2]), static_cast<double>(seen.q[3])})),
        "ok");
    mavlink::AttPosMocap false_pose = seen;  // from a sender without the key
    false_pose.x += 3.F;
    ground_station.send_unauthorized(mavlink::encode(false_pose, GroundStation::kSender, 0).bytes());
  };
  ground_station.start_autopilot(events);
  ASSERT_TRUE(ground_station.start(fly_words(ground_station, key_file(GroundStation::key_text()).string()), errors))
      << error();
  const auto receive_until = [&](const std::function<bool(const Json&)>& condition) {
    for (int round = 0; round < 2000; ++round) {
      (void)ground_station.run_until([] { return false; }, 0.1);
      usleep(5000);  // m100 sends from a thread that runs in real time
      if (condition(node.state())) {
        return true;
      }
    }
    return false;
  };
  ASSERT_TRUE(receive_until([](const Json& state) { return !state["position"].is_null() && state["battery"] >= 0; }));
  ASSERT_TRUE(receive_until([&](const Json& state) {
    if (!state["answers"].contains("92")) {
      (void)node.ask("order 92 1");
    }
    return state["armed"].get<bool>();
  })) << error();
  const std::array<double, 3> start = truth;
  for (const auto& [x, y] : {std::pair{1.0, 0.0}, {1.0, 1.0}, {0.0, 1.0}, {0.0, 0.0}}) {
    const std::array<double, 3> corner{start[0] + x, start[1] + y, start[2]};
    for (int second = 0; second < 10; ++second) {
      EXPECT_EQ(node.ask("goal" + numbers({corner[0], corner[1], corner[2]})), "ok");
      (void)ground_station.run_until([] { return false; }, 1.0);
    }
    EXPECT_LT(std::hypot(truth[0] - corner[0], truth[1] - corner[1], truth[2] - corner[2]), 0.25);
    const double frames = node.state()["frames"].get<double>();
    ASSERT_TRUE(receive_until([&](const Json& state) { return state["frames"] > frames + 6; }));
    const Json read = node.state()["position"];
    EXPECT_NEAR(read[0].get<double>(), corner[0], 0.25);
    EXPECT_NEAR(read[1].get<double>(), corner[1], 0.25);
    EXPECT_NEAR(read[2].get<double>(), corner[2], 0.25);
  }
  int rounds = 0;
  ASSERT_TRUE(receive_until([&](const Json& state) {
    if (rounds++ % 50 == 0) {
      (void)node.ask("parameters");
      (void)node.ask("lists");
    }
    return state["parameters"].contains("MAV_SYS_ID") && !state["items"].is_null() && !state["uploaded"].is_null();
  }));
  const Json state = node.state();
  EXPECT_EQ(state["items"], 0);
  EXPECT_EQ(state["uploaded"], 3) << "unsupported";
  EXPECT_EQ(state["wrong"], 0) << "frames of m100 are not signed with the key";
  EXPECT_NE(state["text"].get<std::string>().find("failsafe: silent to nominal"), std::string::npos) << state["text"];
  for (int tries = 0; tries < 30 && !ground_station.ended(); ++tries) {
    (void)node.ask("order 92 0");
    (void)ground_station.run_until([] { return false; }, 0.3);
  }
  ASSERT_EQ(ground_station.run_to_end(30.0), 0) << error();
  const Json counts = reported()["pose_link"]["signatures"];
  EXPECT_GT(counts["accepted"], 3000);
  EXPECT_GT(counts["unsigned"], 3000);
  EXPECT_GT(counts["replayed"], 100) << "doubled and overtaken packets";
  EXPECT_EQ(counts["wrong"], 0);
}

}  // namespace
}  // namespace m100::ground_station
