// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/body/physics_link.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/resource.h>
#include <unistd.h>

#include <atomic>
#include <functional>
#include <thread>

#include "host_tests/refusal.h"
#include "host_tests/sim/body/body_choice.h"
#include "host_tests/sim/body/step_response.h"
#include "host_tests/sim/ports/loopback_socket.h"

namespace m100::sim {
namespace {

using std::chrono::milliseconds;
constexpr std::array<std::uint16_t, 16> kPulses{};
constexpr PhysicsLink::Patience kShort{
    .first = milliseconds(3000), .later = milliseconds(3000), .again = milliseconds(100)};

std::string answer_at(double time_s) {
  return "{\"timestamp\": " + std::to_string(time_s) +
         ", \"imu\": {\"gyro\": [0,0,0], \"accel_body\": [0,0,-9.8]}, \"position\": [0,0,0], \"velocity\": [0,0,0], "
         "\"attitude\": [0,0,0]}";
}

/// A physics program in a thread: for the n-th packet (from 0) it sends the answers that the test wants.
class Peer {
 public:
  using Answers = std::function<std::vector<std::string>(int packet)>;
  explicit Peer(Answers answers) : answers_(std::move(answers)) {
    address_ = {.host = "127.0.0.1", .port = socket_.port()};
    const timeval tick{.tv_sec = 0, .tv_usec = 10000};
    ::setsockopt(socket_.number(), SOL_SOCKET, SO_RCVTIMEO, &tick, sizeof(tick));
    thread_ = std::thread([this] { serve(); });
  }
  ~Peer() {
    ends_ = true;
    thread_.join();
  }
  const PhysicsAddress& address() const { return address_; }

 private:
  void serve() {
    for (int packet = 0; !ends_;) {
      std::array<char, 64> bytes{};
      sockaddr_in from{};
      socklen_t size = sizeof(from);
      if (::recvfrom(socket_.number(), bytes.data(), bytes.size(), 0, reinterpret_cast<sockaddr*>(&from), &size) !=
          40) {
        continue;
      }
      for (const std::string& text : answers_(packet++)) {
        ::sendto(socket_.number(), text.data(), text.size(), 0, reinterpret_cast<const sockaddr*>(&from), size);
      }
    }
  }
  Answers answers_;
  PhysicsAddress address_;
  LoopbackSocket socket_;
  std::atomic<bool> ends_ = false;
  std::thread thread_;
};

std::string failure(const Peer& peer, int exchanges) {
  return host_tests::refusal_by<PhysicsError>([&] {
    PhysicsLink link(peer.address(), 400, kShort);
    for (int i = 0; i < exchanges; ++i) {
      link.exchange(kPulses);
    }
  });
}

TEST(PhysicsLink, SendsALostPacketAgainAndDropsRepeatedAndLateAnswers) {
  Peer peer([](int packet) -> std::vector<std::string> {
    switch (packet) {
      case 0:
        return {answer_at(1.0)};
      case 1:
        return {};  // lost
      case 2:
        return {answer_at(1.0), answer_at(1.0025), answer_at(1.0025)};  // late, good, twice
      default:
        return {answer_at(1.0025), answer_at(1.005)};
    }
  });
  PhysicsLink link(peer.address(), 400, kShort);
  EXPECT_EQ(link.exchange(kPulses).time_s, 1.0);
  EXPECT_EQ(link.exchange(kPulses).time_s, 1.0025);
  EXPECT_EQ(link.exchange(kPulses).time_s, 1.005);
  EXPECT_GE(link.dropped(), 2U);
}

TEST(PhysicsLink, SaysWhatIsWrongWithTheTime) {
  const auto second = [](double time_s) {
    return Peer::Answers(
        [time_s](int packet) -> std::vector<std::string> { return {answer_at(packet == 0 ? 5.0 : time_s)}; });
  };
  EXPECT_NE(failure(Peer(second(5.02)), 2).find("steps by 20 ms"), std::string::npos);
  EXPECT_NE(failure(Peer(second(5.00001)), 2).find("steps by 0.01 ms"), std::string::npos);
  EXPECT_NE(failure(Peer(second(0.0025)), 2).find("begun anew"), std::string::npos);
  EXPECT_NE(failure(Peer(second(5.0)), 2).find("stands still"), std::string::npos);
  EXPECT_EQ(failure(Peer(second(5.001)), 2), "");  // its own rate of 1000 Hz is as good
}

TEST(PhysicsLink, SaysThatNobodyAnswers) {
  EXPECT_NE(failure(Peer([](int) { return std::vector<std::string>{}; }), 1).find("no answer within 3 s"),
            std::string::npos);
  EXPECT_NE(failure(Peer([](int) { return std::vector<std::string>{"{}"}; }), 1).find("no 'timestamp'"),
            std::string::npos);
}

TEST(Body, HasItsChargeAtTheStartOfTheWorldsTime) {
  Peer peer([](int packet) -> std::vector<std::string> { return {answer_at(1.0 + 0.0025 * packet)}; });
  Plant plant;
  plant.battery.start_percent = 60.0;
  Body body(plant, 1, peer.address());
  for (int step = 0; step < 400; ++step) {
    body.advance(milliseconds(10));
  }
  EXPECT_LT(body.state().battery_percent, 59.9);
  body.start_time();
  body.advance(milliseconds(10));
  EXPECT_NEAR(body.state().battery_percent, 60.0, 0.01);
}

TEST(PhysicsProgram, EndsWithItsOwner) {
  pid_t process = -1;
  {
    PhysicsProgram program("cd / && sleep 1000");
    EXPECT_EQ(program.ending(), "");
    PhysicsProgram fails("exit 3");
    for (int look = 0; look < 1000 && fails.ending().empty(); ++look) {
      std::this_thread::sleep_for(milliseconds(10));
    }
    EXPECT_EQ(fails.ending(), "exit code 3");
    process = program.process();
    EXPECT_EQ(::kill(process, 0), 0);
  }
  EXPECT_NE(::kill(process, 0), 0);
}

TEST(PhysicsProgram, CountsTheProcessorTimeOfWhatAShellStarted) {
  const auto used_s = [] {
    rusage used{};
    ::getrusage(RUSAGE_CHILDREN, &used);
    return static_cast<double>(used.ru_utime.tv_sec) + 1e-6 * static_cast<double>(used.ru_utime.tv_usec);
  };
  const double before_s = used_s();
  std::array<int, 2> ready{};
  ASSERT_EQ(::pipe(ready.data()), 0);
  {
    PhysicsProgram program("sh -c 'i=0; while [ $i -lt 300000 ]; do i=$((i+1)); done; echo >&" +
                           std::to_string(ready[1]) + "; sleep 1000'; true");
    char done = 0;
    EXPECT_EQ(::read(ready[0], &done, 1), 1);
  }
  EXPECT_GT(used_s() - before_s, 0.02);
  ::close(ready[0]);
  ::close(ready[1]);
}

TEST(BodyChoice, RefusesWordsThatMeanNothing) {
  for (const char* const words : {"", "json", "json:", "json:9002", "json::9002", "json:host:", "json:host:0",
                                  "json:host:70000", "json:host:90x", "gazebo:1.2.3.4:9002"}) {
    EXPECT_THROW((BodyChoice{.body = words, .command = ""}.check()), PhysicsError) << words;
  }
  EXPECT_NO_THROW((BodyChoice{.body = "json:127.0.0.1:9002", .command = ""}.check()));
  EXPECT_THROW((BodyChoice{.body = "identified", .command = "world 9002"}.check()), PhysicsError);
  EXPECT_THROW((BodyChoice{.body = "json:127.0.0.1:9002", .command = "world {port}"}.check()), PhysicsError);
}

// Recovery: a second order with known numbers, its delay and lead zero included.
TEST(FitStep, RecoversTheSecondOrderThatMadeTheSamples) {
  constexpr double kStep_s = 0.0025;
  std::vector<double> samples;
  double x = 0.0, rate = 0.0;
  for (double t_s = 0.0; t_s < 1.5; t_s += kStep_s) {
    rate += kStep_s * (49.0 * ((t_s >= 0.05 ? 1.0 : 0.0) - x) - 2.0 * 0.75 * 7.0 * rate);
    x += kStep_s * rate;
    samples.push_back(x + 0.1 * rate);
  }
  const SecondOrder found = fit_step(samples, kStep_s, 0.05, 0.1);
  EXPECT_NEAR(found.frequency_rad_s, 7.0, 0.05);
  EXPECT_NEAR(found.damping_ratio, 0.75, 0.01);
}

}  // namespace
}  // namespace m100::sim
