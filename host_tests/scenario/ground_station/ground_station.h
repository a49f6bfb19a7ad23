// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host_tests/scenario/program/process.h"
#include "host_tests/sim/ports/lockstep_host.h"
#include "host_tests/sim/ports/loopback_socket.h"
#include "host_tests/sim/world/random.h"
#include "protocol/mavlink/parser.h"
#include "protocol/mavlink/pose_messages.h"
#include "protocol/mavlink/signature.h"

namespace m100::ground_station {

using Packet = std::vector<std::byte>;
using scenario::with;
using Socket = sim::LoopbackSocket;
using scenario::Words;

/// The faults of the network, and the resulting counts.
struct Network {
  double lost = 0.0;     ///< share of the packets
  double doubled = 0.0;  ///< share that arrives twice
  double swapped = 0.0;  ///< share that arrives after the next packet
  std::uint64_t given = 0;
  std::uint64_t newer = 0;      ///< packets that arrived with a stamp newer than all before
  std::uint64_t not_newer = 0;  ///< packets that arrived doubled or overtaken
};

/// A room with motion capture. `m100-lab autopilot` is the aircraft; the room signs its poses and sends them to `m100`
/// over UDP, through a network that loses, doubles and reorders packets. All programs run in simulated time: the same
/// seed gives the same flight, and nothing depends on the load of the machine.
class GroundStation {
 public:
  GroundStation(std::filesystem::path folder, std::uint64_t seed);

  void start_autopilot(const std::filesystem::path& events, const std::vector<std::string>& more = {});
  /// Starts m100 and waits until it takes part in simulated time. @returns false if it has ended.
  bool start(const std::vector<std::string>& words, const std::filesystem::path& errors);
  /// Advances by one time step: bytes of the autopilot's line, poses, packets.
  void step();
  /// @returns the exit code of m100; empty if it still runs after this simulated time.
  std::optional<int> run_to_end(double at_most_s);
  bool run_until(const std::function<bool()>& condition, double at_most_s);
  double now_s() const { return core::seconds<double>(host_.now().time_since_epoch()); }
  bool ended() const { return ending_.has_value(); }
  void signal(int number) const { program_->send(number); }

  std::string port() const { return "sim:" + (folder_ / "port").string(); }
  std::string pose_port() const { return "udp:" + std::to_string(m100_port_); }

  /// Signs a frame and sends it through the network. @returns the packet.
  Packet send(mavlink::Frame frame);
  /// Sends a packet unchanged, without the network's faults, from another socket.
  void send_unauthorized(std::span<const std::byte> packet) const { unauthorized_.send(m100_port_, packet); }
  mavlink::SignatureTime stamp();

  static constexpr mavlink::Key kKey = [] {
    mavlink::Key key{};
    for (std::size_t i = 0; i < key.size(); ++i) {
      key[i] = static_cast<std::byte>(7 * i + 1);
    }
    return key;
  }();
  static std::string key_text();
  static constexpr mavlink::Address kSender{.system = 9, .component = 197};
  static constexpr std::uint8_t kLink = 3;

  Network network;
  bool sends_poses = true;
  std::function<void(const mavlink::AttPosMocap&)> on_pose{};  ///< called with each true pose
  std::function<void(const mavlink::FrameView&)> on_frame{};   ///< called with each frame of m100
  std::uint64_t wrongly_signed = 0;                            ///< frames of m100 that are not signed with the key
  std::vector<Packet> recorded{};                              ///< all signed packets
  std::uint8_t frames = 0;                                     ///< number of our next frame
  const Socket& unauthorized() const { return unauthorized_; }

 private:
  void deliver(const Packet& packet, mavlink::SignatureTime stamp);
  void listen();

  std::filesystem::path folder_;
  sim::Random random_;
  sim::LockstepHost host_;
  Socket sender_;
  Socket unauthorized_;
  std::uint16_t m100_port_;
  mavlink::Parser poses_;
  std::unique_ptr<scenario::Process> autopilot_;
  std::unique_ptr<scenario::Process> program_;
  std::optional<int> ending_;
  std::optional<std::pair<Packet, mavlink::SignatureTime>> held_back_;
  mavlink::SignatureTime last_stamp_ = 0;
  mavlink::SignatureTime newest_given_ = 0;
};

}  // namespace m100::ground_station
