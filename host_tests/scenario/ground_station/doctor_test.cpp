// SPDX-License-Identifier: BSD-3-Clause
// m100 doctor at the pose port: a missing key, poses over the bridge, wrong axes; and the live values of a flight.
#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <functional>
#include <optional>
#include <string>
#include <thread>

#include "host_tests/scenario/ground_station/ground_station_flight.h"
#include "protocol/mavlink/pose_messages.h"

namespace m100::ground_station {
namespace {

struct Doctor : GroundStationTest {
  /// Result of a check of the last run: "good: ..." or "bad: ...".
  std::string check(const std::string& name) const {
    const Json all = reported();
    for (const Json& one : all["checks"]) {
      if (one["name"] == name) {
        return one["health"].get<std::string>() + ": " + one["finding"].get<std::string>();
      }
    }
    return "";
  }
  void examine(const std::vector<std::string>& more) {
    const Words words{"doctor", "--load", "0", "--folder", folder.string(), "--json", result.string()};
    (void)run(with(words, more));  // other findings on this machine do not matter here
  }
};

TEST_F(Doctor, KnowsANetworkAndItsKey) {
  examine({"--pose-port", ground_station->pose_port()});
  EXPECT_NE(check("pose port " + ground_station->pose_port()).find("bad: --pose-port: "), std::string::npos);
  EXPECT_NE(check("pose port " + ground_station->pose_port()).find("must be signed; name the key with --mavlink-key"),
            std::string::npos);
  EXPECT_EQ(check("pose line"), "") << "a network has no baud rate";
  examine({"--pose-port", ground_station->pose_port(), "--mavlink-key", key + "none"});
  EXPECT_NE(check("pose port " + ground_station->pose_port()).find("cannot be read"), std::string::npos);
  examine({"--pose-port", ground_station->pose_port(), "--mavlink-key", key});
  EXPECT_EQ(check("pose port " + ground_station->pose_port()), "good: opens, and the key can be read");
  EXPECT_NE(check("poses").find("bad: none came; not one byte came"), std::string::npos) << check("poses");
}

TEST_F(Doctor, RefusesAMessageThatDoesNotFitItsLine) {
  examine({"--pose-message", "ODOMETRY", "--pose-baud", "230400"});
  EXPECT_EQ(check("pose line"), "bad: ODOMETRY (245 bytes) at 100 Hz takes 106 % of 230400 baud");
  examine({"--pose-message", "ATT_POS_MOCAP", "--pose-baud", "57600", "--pose-rate", "95"});
  EXPECT_EQ(check("pose line").substr(0, 4), "good");
  examine({"--pose-message", "ATT_POS_MOCAP", "--pose-baud", "57600", "--pose-rate", "95", "--mavlink-key", key});
  EXPECT_EQ(check("pose line").substr(0, 4), "bad:") << "a signature adds 13 bytes: " << check("pose line");
}

// The bridge and m100 run in real time. The number of poses in two seconds is not judged, and the two seconds begin
// when the bridge listens.
TEST_F(Doctor, SeesPosesThatComeOverTheBridge) {
  const Socket source;
  const std::uint16_t listens = Socket().port();
  std::array<int, 2> pipe{};
  ASSERT_EQ(::pipe2(pipe.data(), O_CLOEXEC), 0);
  scenario::Process bridge(M100_LAB_PROGRAM,
                           {"bridge", "--listen", "udp:" + std::to_string(listens), "--to",
                            "127.0.0.1:" + ground_station->pose_port().substr(4), "--mavlink-key", key, "--stamp",
                            "arrival", "--json", (folder / "bridge.json").string()},
                           {}, pipe[1]);
  ::close(pipe[1]);
  char first = 0;
  ASSERT_EQ(::read(pipe[0], &first, 1), 1) << "the bridge ended before it listened";  // its first line: it listens
  std::atomic<bool> over{false};
  std::thread sends([&] {
    for (int i = 0; !over; ++i) {
      const std::string text = i % 10 == 0 ? "nonsense" : "1.0 0.5 -0.25 1.5 1 0 0 0";
      source.send(listens, std::as_bytes(std::span(text)));
      usleep(5000);
    }
  });
  examine({"--pose-port", ground_station->pose_port(), "--mavlink-key", key});
  over = true;
  sends.join();
  EXPECT_NE(check("poses").substr(0, 3), "bad") << check("poses");
  EXPECT_NE(check("poses").find("frames signed with the key; refused: 0 unsigned, 0 with a wrong signature"),
            std::string::npos)
      << check("poses");
  bridge.send(SIGINT);
  EXPECT_EQ(bridge.wait(), 0);
  ::close(pipe[0]);
  const Json counts = Json::parse(scenario::text_of(folder / "bridge.json"));
  EXPECT_GT(counts["sent"], 0);
  EXPECT_GT(counts["refused"], 0);
}

TEST_F(Doctor, TheBridgeSaysWhatIsWrong) {
  EXPECT_EQ(run_lab({"bridge", "--mavlink-key", key, "--to", "somewhere", "--duration", "1"}), 2);
  EXPECT_EQ(run_lab({"bridge", "--mavlink-key", key, "--listen", "9763", "--duration", "1"}), 2);
  EXPECT_EQ(run_lab({"bridge", "--mavlink-key", key + "none", "--duration", "1"}), 2);
  EXPECT_EQ(run_lab({"bridge", "--mavlink-key", key, "--from", "somebody", "--duration", "1"}), 2);
  EXPECT_EQ(run_lab({"bridge", "--duration", "1"}), 2);
  const std::uint16_t free = Socket().port();
  EXPECT_EQ(run_lab({"bridge", "--mavlink-key", key, "--listen", "udp:" + std::to_string(free), "--duration", "0.2"}),
            1)
      << "no pose arrived";
}

/// The pilot's sticks move the aircraft instead of a person's hands; the pose's axes are changed on the way.
struct Frames : Doctor {
  std::string script() const {
    return made("hands.txt",
                "3 doublet pitch 250 1\n8 doublet roll 250 1\n13 doublet yaw 600 1.5\n18 doublet throttle 300 "
                "1\n23 doublet pitch 250 1\n28 doublet roll 250 1\n");
  }
  void move(const std::function<void(mavlink::AttPosMocap&)>& change) {
    ground_station->sends_poses = false;
    ground_station->on_pose = [this, change](const mavlink::AttPosMocap& seen) {
      mavlink::AttPosMocap changed = seen;
      change(changed);
      (void)ground_station->send(mavlink::encode(changed, GroundStation::kSender, ground_station->frames++));
      if (has_stray) {
        changed.x = -changed.x;
        (void)ground_station->send(mavlink::encode(changed, {99, 1}, ground_station->frames));
      }
    };
    ground_station->start_autopilot(events, {"--script", script(), "--rc-mode", "A"});
    ASSERT_TRUE(ground_station->start(
        {"doctor", "--frames", "--port", ground_station->port(), "--pose-port", ground_station->pose_port(),
         "--mavlink-key", key, "--hold", "34", "--json", result.string()},
        errors))
        << error();
    ending = ground_station->run_to_end(60.0);
  }
  bool has_stray = false;
  std::optional<int> ending;
};

TEST_F(Frames, TwoSendersAreNamed) {
  has_stray = true;
  move([](mavlink::AttPosMocap&) {});
  EXPECT_EQ(ending, 1);
  EXPECT_NE(check("frames").find("poses come from several senders"), std::string::npos) << check("frames");
}

TEST_F(Frames, RightAxesAreRight) {
  move([](mavlink::AttPosMocap&) {});
  EXPECT_EQ(ending, 0) << reported().dump(1);
  for (const char* const name : {"heading", "position x", "position y", "position z"}) {
    EXPECT_EQ(check(name).substr(0, 5), "good:") << check(name);
  }
  EXPECT_EQ(check("lever arm").substr(0, 5), "good:") << check("lever arm");
  EXPECT_NE(check("roll").find("the pose does not show this motion"), std::string::npos)
      << "the emulator sends only the heading";
}

// Catches a lever arm in wrong axes or signs, and one that is proposed where there is none.
TEST_F(Frames, ALeverArmIsProposedAfterATurn) {
  move([](mavlink::AttPosMocap& seen) {
    const float yaw = 2.F * std::atan2(seen.q[3], seen.q[0]);  // the emulator sends only the heading; NED
    seen.x += 0.2F * std::cos(yaw) + 0.1F * std::sin(yaw);     // 0.2 m ahead, 0.1 m left
    seen.y += 0.2F * std::sin(yaw) - 0.1F * std::cos(yaw);
  });
  EXPECT_EQ(ending, 0) << reported().dump(1);
  double ahead_m = 0.0, left_m = 0.0;
  ASSERT_EQ(std::sscanf(check("lever arm").c_str(), "doubtful: the origin of the pose lies %lf m ahead and %lf m left",
                        &ahead_m, &left_m),
            2)
      << check("lever arm");
  EXPECT_LT(std::hypot(ahead_m - 0.2, left_m - 0.1), 0.3 * 0.22) << check("lever arm");
}

TEST_F(Frames, AReversedAxisIsNamed) {
  move([](mavlink::AttPosMocap& seen) { seen.y = -seen.y; });
  EXPECT_EQ(ending, 1);
  EXPECT_EQ(check("position y").substr(0, 16), "bad: is reversed") << reported().dump(1);
  EXPECT_EQ(check("position x").substr(0, 5), "good:");
  EXPECT_EQ(check("heading").substr(0, 5), "good:");
}

// A hover by hand, and the vibration of a chipped propeller in it.
TEST_F(Doctor, TheVibrationIsMeasuredAndItsLevelsAreSaid) {
  for (const auto& [vibration_m_s2, health] : {std::pair{0.03, "good"}, {3.0, "doubtful"}}) {
    const std::string text = "[sensors]\nimu_vibration_m_s2 = " + std::to_string(vibration_m_s2) + "\n";
    ground_station->start_autopilot(events, {"--plant", made("plant.toml", text), "--rc-mode", "A"});
    ASSERT_TRUE(ground_station->start({"doctor", "--load", "0", "--folder", folder.string(), "--port",
                                       ground_station->port(), "--json", result.string()},
                                      errors))
        << error();
    (void)ground_station->run_to_end(60.0);  // other findings on this machine do not matter here
    double rms_m_s2 = 0.0;
    const std::string seen = check("vibration");
    const std::size_t colon = seen.find("15 Hz: ");
    ASSERT_NE(colon, std::string::npos) << seen;
    ASSERT_EQ(std::sscanf(seen.c_str() + colon, "15 Hz: %lf m/s^2 rms on an axis, peak", &rms_m_s2), 1) << seen;
    EXPECT_GT(rms_m_s2, 0.4 * vibration_m_s2) << seen;  // of 50 white readings a second 0.55 is left above 15 Hz
    EXPECT_LT(rms_m_s2, 1.1 * vibration_m_s2) << seen;
    EXPECT_EQ(seen.substr(0, seen.find(':')), health) << seen;
    EXPECT_NE(seen.find("a healthy M100 shows 0.02 to 0.03"), std::string::npos) << seen;
  }
}

TEST_F(Doctor, FramesNeedsBothPorts) {
  EXPECT_EQ(run({"doctor", "--frames", "--port", ground_station->port()}), 2);
  EXPECT_NE(error().find("--frames: needs --port and --pose-port"), std::string::npos) << error();
}

// The live values of a flight, read as PlotJuggler would do.
TEST_F(Doctor, AFlightIsShownWhileItFlies) {
  const Socket plot;
  ground_station->start_autopilot(events);
  const Words live{"--take-control", "--once", "--hold", "8", "--live", "127.0.0.1:" + std::to_string(plot.port()),
                   "--status",       "always"};
  double last_s = -1.0;
  int in_control = 0, states = 0;
  // Reads during the flight, because a full socket drops packets.
  const auto read = [&] {
    while (const std::optional<Packet> packet = plot.receive()) {
      const Json state = Json::parse(std::string(reinterpret_cast<const char*>(packet->data()), packet->size()));
      EXPECT_GT(state["timestamp"], last_s);
      last_s = state["timestamp"].get<double>();
      in_control += state["in_control"].get<int>();
      ++states;
    }
  };
  ground_station->on_pose = [&](const mavlink::AttPosMocap&) { read(); };
  ASSERT_TRUE(ground_station->start(with(fly_words(*ground_station, key), live), errors)) << error();
  ASSERT_EQ(ground_station->run_to_end(60.0), 0) << error();
  read();
  EXPECT_GT(states, 10) << "a busy machine may drop some, but not most";
  EXPECT_GT(in_control, 0);
  EXPECT_GT(last_s, 5.0);
}

}  // namespace
}  // namespace m100::ground_station
