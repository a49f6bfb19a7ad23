// SPDX-License-Identifier: BSD-3-Clause
// m100-lab bridge: receives motion-capture poses and sends them on to m100 as signed MAVLink.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <iostream>
#include <memory>

#include "firmware/companion/command_line.h"
#include "firmware/companion/files/file_use.h"
#include "firmware/companion/files/text/key_file.h"
#include "firmware/link/pose/pose_fault.h"
#include "hal/linux/descriptor.h"
#include "hal/linux/udp_port.h"
#include "host_tests/lab/bridge/plain_pose.h"
#include "host_tests/lab/bridge/sender.h"
#include "host_tests/lab/bridge/vrpn_source.h"
#include "host_tests/lab/input_error.h"
#include "host_tests/lab/json_file.h"
#include "host_tests/lab/printable.h"
#include "host_tests/lab/subcommands.h"
#include "protocol/mavlink/parser.h"
#include "protocol/mavlink/signature.h"

namespace m100::lab {
namespace {

using bridge::Sender;
using hal::Descriptor;

struct BridgeOptions {
  std::string listen = "udp:9763";
  std::string from = "127.0.0.1";
  std::string vrpn;
  int sensor = 0;
  std::string to = "127.0.0.1:14560";
  std::string key_file;
  std::string axes = "nwu";
  std::string stamp = "sender";
  double duration_s = 0.0;
  std::string json;
};

struct Counts {
  std::uint64_t packets = 0, refused = 0, sent = 0, lost = 0, asked = 0;
  std::uint64_t strangers = 0;                            ///< packets from another address
  std::array<std::uint64_t, link::kPoseFaults> faults{};  ///< packets refused for each fault; [0]: not eight numbers
};

/// The refused packets by their reasons, one line each.
std::string describe_refusals(const Counts& counts) {
  std::string text;
  const auto add = [&](std::uint64_t count, const std::string& what) {
    text += count > 0 ? "  refused: " + std::to_string(count) + " with " + what + "\n" : "";
  };
  add(counts.strangers, "another sender's address (--from)");
  add(counts.faults[0], "other text than eight numbers: t x y z qw qx qy qz, with decimal points");
  for (std::size_t i = 1; i < counts.faults.size(); ++i) {
    const bool is_time = static_cast<link::PoseFault>(i) == link::PoseFault::kFastStamp;
    add(counts.faults[i], is_time ? "a time that is not seconds: milliseconds or nanoseconds?"
                                  : std::string(link::kPoseFaultTexts[i].sentence));
  }
  return text;
}

std::atomic<bool> stopped{false};
void on_signal(int) { stopped = true; }

std::uint64_t now_us() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::microseconds>(now).count());
}

/// Reads what m100 sent. If poses carry time stamps of our clock, answers signed time-sync requests with that clock.
void answer_time_request(Sender& sender, bool answers_time, const mavlink::Key& key, Counts& counts) {
  std::array<std::byte, 2048> packet{};
  for (ssize_t size = ::recv(sender.descriptor(), packet.data(), packet.size(), 0); size > 0;
       size = ::recv(sender.descriptor(), packet.data(), packet.size(), 0)) {
    mavlink::Parser parser;
    parser.consume(std::span<const std::byte>(packet).first(static_cast<std::size_t>(size)),
                   [&](const mavlink::FrameView& frame) {
                     if (!mavlink::is<mavlink::Timesync>(frame) || !is_signed_with(frame, key)) {
                       return;
                     }
                     const auto question = mavlink::decode<mavlink::Timesync>(frame);
                     if (question.tc1 == 0 && answers_time) {
                       ++counts.asked;
                       (void)sender.send(
                           mavlink::Timesync{.tc1 = static_cast<std::int64_t>(now_us()) * 1000, .ts1 = question.ts1});
                     }
                   });
  }
}

void forward_pose(const bridge::PlainPose& pose, const BridgeOptions& options, Sender& sender, Counts& counts) {
  const std::uint64_t stamp =
      options.stamp == "arrival" ? now_us() : static_cast<std::uint64_t>(std::llround(pose.t_s * 1e6));
  const bool left = sender.send(message_of(pose, *bridge::axes_of(options.axes), stamp));
  ++(left ? counts.sent : counts.lost);
}

in_addr address_of(const std::string& text) {
  in_addr address{};
  if (inet_pton(AF_INET, text.c_str(), &address) != 1) {
    throw InputError("--from", 0, "", text + " is not an IPv4 address");
  }
  return address;
}

/// The socket for the source's packets. They are not signed, so with --from 127.0.0.1 it listens on the loopback
/// interface only, which no other machine reaches.
Descriptor listening_socket(const std::string& name, in_addr from) {
  const std::optional<std::uint16_t> port = hal::udp_port_of(name);
  if (!port) {
    throw InputError("--listen", 0, "", name + ": a UDP port is written udp:PORT, PORT from 1 to 65535");
  }
  Descriptor socket(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(*port);
  address.sin_addr.s_addr = htonl(from.s_addr == htonl(INADDR_LOOPBACK) ? INADDR_LOOPBACK : INADDR_ANY);
  if (socket.number < 0 || ::bind(socket.number, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0) {
    throw InputError("--listen", 0, "", name + ": no permission to open it, or another program holds it");
  }
  return socket;
}

/// The source of the poses: plain packets, or a VRPN server.
class Source {
 public:
  virtual ~Source() = default;
  virtual int descriptor() const = 0;
  /// Reads the waiting bytes. @returns false: the source has ended.
  virtual bool read(Counts& counts, const bridge::VrpnStream::Use& use) = 0;
  /// Why no pose has arrived; empty: unknown.
  virtual std::string silence_reason() const { return ""; }
};

class Packets final : public Source {
 public:
  Packets(const std::string& name, in_addr from) : from_(from), socket_(listening_socket(name, from)) {}
  int descriptor() const override { return socket_.number; }
  bool read(Counts& counts, const bridge::VrpnStream::Use& use) override {
    std::array<std::byte, 2048> packet{};
    for (ssize_t size = receive(packet); size >= 0; size = receive(packet)) {
      ++counts.packets;
      const auto bytes = std::span<const std::byte>(packet).first(static_cast<std::size_t>(size));
      link::PoseFault fault = link::PoseFault::kNone;
      const auto pose = bridge::parse_packet(bytes, &fault);
      const bool is_ours = sender_.sin_addr.s_addr == from_.s_addr;
      if (pose && is_ours) {
        use(*pose);
      } else {
        ++counts.refused;
        ++(is_ours ? counts.faults[static_cast<std::size_t>(fault)] : counts.strangers);
      }
    }
    return true;
  }

 private:
  ssize_t receive(std::span<std::byte> packet) {
    socklen_t length = sizeof(sender_);
    return ::recvfrom(socket_.number, packet.data(), packet.size(), 0, reinterpret_cast<sockaddr*>(&sender_), &length);
  }
  in_addr from_;
  sockaddr_in sender_{};
  Descriptor socket_;
};

class Vrpn final : public Source {
 public:
  Vrpn(const bridge::VrpnName& name, int sensor) : stream_(name.tracker, sensor), connection_(bridge::connect(name)) {}
  int descriptor() const override { return connection_.number; }
  bool read(Counts& counts, const bridge::VrpnStream::Use& use) override {
    const bool goes_on = bridge::read(connection_, stream_, use);
    counts.packets = stream_.messages();
    counts.refused = stream_.passed_over();
    if (!goes_on) {
      std::cerr << "m100-lab: --vrpn: the connection has ended, or the server does not speak VRPN\n";
    }
    return goes_on;
  }
  std::string silence_reason() const override { return stream_.silence_reason(); }

 private:
  bridge::VrpnStream stream_;
  Descriptor connection_;
};

std::unique_ptr<Source> source_of(const BridgeOptions& options) {
  if (options.vrpn.empty()) {
    return std::make_unique<Packets>(options.listen, address_of(options.from));
  }
  return std::make_unique<Vrpn>(bridge::vrpn_name(options.vrpn), options.sensor);
}

Counts run_bridge(const BridgeOptions& options, const mavlink::Key& key) {
  Sender sender(options.to, key);
  const std::unique_ptr<Source> source = source_of(options);
  std::cout << "from " << (options.vrpn.empty() ? options.listen : options.vrpn) << " to " << options.to << ", signed"
            << std::endl;
  Counts counts;
  const std::uint64_t begin_us = now_us();
  const auto is_over = [&] {
    return options.duration_s > 0.0 && static_cast<double>(now_us() - begin_us) >= 1e6 * options.duration_s;
  };
  bool goes_on = true;
  while (goes_on && !stopped && !is_over()) {
    std::array<pollfd, 2> wait{pollfd{.fd = source->descriptor(), .events = POLLIN, .revents = 0},
                               pollfd{.fd = sender.descriptor(), .events = POLLIN, .revents = 0}};
    (void)::poll(wait.data(), wait.size(), 100);
    goes_on = source->read(counts, [&](const bridge::PlainPose& pose) { forward_pose(pose, options, sender, counts); });
    answer_time_request(sender, options.stamp == "arrival", key, counts);
  }
  if (const std::string why = source->silence_reason(); counts.sent == 0 && !why.empty()) {
    std::cerr << printable("m100-lab: --vrpn: " + why) << "\n";
  }
  return counts;
}

void run(const BridgeOptions& options) {
  companion::FileUse().reads("--mavlink-key", options.key_file).writes("--json", options.json).check();
  const protocol::CipherKey read = companion::read_key(options.key_file);
  mavlink::Key key;
  std::transform(read.begin(), read.end(), key.begin(), [](std::uint8_t byte) { return std::byte{byte}; });
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
  const Counts counts = run_bridge(options, key);
  std::cout << counts.sent << " poses passed on, " << counts.refused << " packets refused, " << counts.lost
            << " not sent, " << counts.asked << " time requests answered\n"
            << describe_refusals(counts);
  write_json(options.json, Json{{"packets", counts.packets},
                                {"refused", counts.refused},
                                {"sent", counts.sent},
                                {"not_sent", counts.lost},
                                {"answers", counts.asked}});
  if (counts.sent == 0) {
    throw companion::AnswerIsNo();
  }
}

}  // namespace

void add_bridge(companion::CommandLine& lab) {
  const auto [app, options] =
      lab.add_subcommand<BridgeOptions>("bridge",
                                        "send poses of a room, from plain UDP packets or a VRPN server, "
                                        "on to m100 fly --pose-port udp:PORT as signed MAVLink",
                                        run);
  app.add_option(
      "--listen", options->listen,
      "port to which the room sends, udp:PORT; only this machine is heard unless --from names another. Example: "
      "--listen udp:9763");
  app.add_option(
      "--from", options->from,
      "IPv4 address of the room's sender; packets from other addresses are refused. Packets are not signed: anyone who "
      "can send from this address can move the aircraft. Example: --from 192.168.1.10");
  app.add_option("--vrpn", options->vrpn,
                 "VRPN server to use instead of packets: TRACKER@HOST or "
                 "TRACKER@HOST:PORT, HOST an IPv4 address; default: "
                 "none. Example: --vrpn m100@192.168.1.10")
      .excludes("--listen")
      .excludes("--from");
  app.add_option("--sensor", options->sensor, "sensor of the tracker. Example: --sensor 1")
      .in_range(0, 10000)
      .needs("--vrpn");
  app.add_option("--to", options->to, "IPv4 address and UDP port of m100. Example: --to 192.168.1.20:14560");
  app.add_option("--mavlink-key", options->key_file,
                 "file with the key of the signatures (64 hexadecimal digits, readable by its owner only), the same as "
                 "m100's. Example: --mavlink-key mavlink.key")
      .required();
  app.add_option("--axes", options->axes,
                 "axes of the room and the body: nwu (x forward, y left, z up), "
                 "ned (MAVLink's own), enu (ROS). Example: "
                 "--axes enu")
      .one_of({"nwu", "ned", "enu"});
  app.add_option("--stamp", options->stamp,
                 "time stamp of a pose. sender: the packet's own time, of a clock that m100 does not see; arrival: the "
                 "time of arrival on this machine's clock, which m100 asks for. Example: --stamp arrival")
      .one_of({"sender", "arrival"});
  app.add_option("--duration", options->duration_s, "seconds; 0: until Ctrl-C. Example: --duration 60")
      .from_to(0.0, 1e6);
  app.add_option("--json", options->json, "counts as JSON. Example: --json bridge.json");
  app.footer(
      "A packet is one pose: t x y z qw qx qy qz, as text separated by spaces or commas, or as 64 bytes of doubles, "
      "little endian. Exit codes: 0 poses were passed on, 1 no pose was passed on, 2 wrong use or bad input.");
}

}  // namespace m100::lab
