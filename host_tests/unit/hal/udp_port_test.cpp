// SPDX-License-Identifier: BSD-3-Clause
#include "hal/linux/udp_port.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <ifaddrs.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <string>
#include <vector>

#include "host_tests/unit/hal/far_side.h"

namespace m100::hal {
namespace {

/// Another program on the loopback of this machine.
class Peer {
 public:
  explicit Peer(in_addr_t from = INADDR_LOOPBACK)
      : descriptor_(not_zero(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0))) {
    sockaddr_in address = at(0, from);
    EXPECT_EQ(::bind(descriptor_.number, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
    socklen_t size = sizeof(address);
    EXPECT_EQ(::getsockname(descriptor_.number, reinterpret_cast<sockaddr*>(&address), &size), 0);
    port_ = ntohs(address.sin_port);
  }
  std::uint16_t port() const { return port_; }
  void send(std::uint16_t port, const std::string& text, in_addr_t to = INADDR_LOOPBACK) const {
    const sockaddr_in address = at(port, to);
    EXPECT_EQ(::sendto(descriptor_.number, text.data(), text.size(), 0, reinterpret_cast<const sockaddr*>(&address),
                       sizeof(address)),
              static_cast<ssize_t>(text.size()));
  }
  /// The next packet; waits for it. If none comes, ctest's time limit ends the test.
  std::string receive() const {
    std::string text(2000, '\0');
    text.resize(static_cast<std::size_t>(::recv(descriptor_.number, text.data(), text.size(), 0)));
    return text;
  }
  bool is_empty() const {
    char byte = 0;
    return ::recv(descriptor_.number, &byte, 1, MSG_DONTWAIT | MSG_PEEK) < 0;
  }

 private:
  static sockaddr_in at(std::uint16_t port, in_addr_t host) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(host);
    return address;
  }
  Descriptor descriptor_;
  std::uint16_t port_ = 0;
};

/// A free port: one that was in use a moment ago.
std::uint16_t free_port() { return Peer().port(); }

struct UdpPortTest : ::testing::Test {
  const std::uint16_t number = free_port();
  UdpPort port{number};
  Peer peer;
  void SetUp() override {
    free_descriptor_zero();
    ASSERT_EQ(port.open(), core::Status::kOk);
  }

  /// Repeats the read until bytes come.
  std::string read(std::size_t at_most) {
    std::vector<std::byte> bytes(at_most);
    std::size_t count = 0;
    while (count == 0) {
      count = port.read(bytes).value_or(0);
    }
    std::string text;
    for (std::size_t i = 0; i < count; ++i) {
      text += static_cast<char>(bytes[i]);
    }
    return text;
  }
};

TEST_F(UdpPortTest, GivesTheBytesOfPacketsInOrderAndSaysWhereOneBegins) {
  std::vector<std::byte> nothing(10);
  EXPECT_EQ(port.read(nothing).value_or(99), 0U) << "nothing has come, and nobody waits";
  peer.send(number, "abcdef");
  peer.send(number, "gh");
  EXPECT_EQ(read(4), "abcd");
  EXPECT_TRUE(port.begins_packet());
  EXPECT_EQ(read(4), "ef") << "a packet is not joined to the next";
  EXPECT_FALSE(port.begins_packet());
  EXPECT_EQ(read(4), "gh");
  EXPECT_TRUE(port.begins_packet());
}

TEST_F(UdpPortTest, APacketThatCameAfterTheMarkWaitsForTheNext) {
  peer.send(number, "ab");
  EXPECT_EQ(read(4), "ab") << "without a mark all is given";
  std::vector<std::byte> bytes(4);
  const auto is_stamped = [&] {
    peer.send(number, "x");
    port.mark_arrived();
    return port.read(bytes).value_or(0) == 1;
  };
  while (!is_stamped()) {  // Linux begins to stamp a moment after it was asked to; until then it stamps what is read
    port.mark_arrived();
    EXPECT_EQ(read(4), "x");
  }
  peer.send(number, "cd");
  port.mark_arrived();
  peer.send(number, "ef");
  EXPECT_EQ(read(4), "cd");
  for (int again = 0; again < 1000; ++again) {
    EXPECT_EQ(port.read(bytes).value_or(9), 0U);
  }
  port.mark_arrived();
  EXPECT_EQ(read(4), "ef");
  EXPECT_TRUE(port.begins_packet());
}

// Would catch a port that delivers the beginning of a packet that is too long, or that takes an empty packet for the
// end.
TEST_F(UdpPortTest, PassesOverWhatIsEmptyOrTooLongInOneCall) {
  std::vector<std::byte> bytes(2000);
  peer.send(number, "");
  peer.send(number, "a");
  EXPECT_EQ(port.read(bytes).value_or(99), 1U);
  const auto send_empty = [this](int packets) {
    for (; packets > 0; --packets) {
      peer.send(number, "");
    }
  };
  send_empty(15);
  peer.send(number, "ab");
  EXPECT_EQ(port.read(bytes).value_or(99), 2U);
  send_empty(16);
  peer.send(number, "abc");
  EXPECT_EQ(port.read(bytes).value_or(99), 0U)
      << "a call takes 16 packets at most, so that a flood cannot hold the tick";
  EXPECT_EQ(port.read(bytes).value_or(99), 3U);
  peer.send(number, "");
  peer.send(number, std::string(UdpPort::kMaxPacketBytes + 1, 'x'));
  peer.send(number, std::string(UdpPort::kMaxPacketBytes, 'y'));
  EXPECT_EQ(read(2000), std::string(UdpPort::kMaxPacketBytes, 'y'));
}

// Would catch a port that answers the last sender: a stranger could redirect the answers to himself.
TEST_F(UdpPortTest, AnswersTheGivenPeerAndNobodyBefore) {
  const std::array greeting{std::byte{'h'}, std::byte{'i'}};
  Peer intruder;
  peer.send(number, "p");
  EXPECT_EQ(read(10), "p");
  EXPECT_FALSE(port.send(greeting));
  EXPECT_EQ(port.write(greeting).value_or(0), 2U) << "a line with nobody at its end takes bytes as well";
  port.answer_last();
  intruder.send(number, "s");
  EXPECT_EQ(read(10), "s");
  EXPECT_EQ(port.write(greeting).value_or(0), 2U);
  EXPECT_EQ(peer.receive(), "hi") << "one packet, and none from before";
  EXPECT_TRUE(peer.is_empty());
  EXPECT_TRUE(intruder.is_empty());
  EXPECT_TRUE(port.send(greeting));
  EXPECT_FALSE(port.send(std::vector<std::byte>(70000))) << "longer than a packet may be";
}

TEST_F(UdpPortTest, TwoProgramsCannotHaveOnePort) {
  UdpPort second(number);
  const auto open = open_files();
  EXPECT_EQ(second.open(), core::Status::kRefused);
  EXPECT_EQ(open_files(), open);
  std::array<std::byte, 4> bytes{};
  EXPECT_EQ(second.read(bytes).status(), core::Status::kUnavailable);
  EXPECT_EQ(second.write(bytes).status(), core::Status::kUnavailable);
}

/// The addresses of this machine's interfaces beside 127.0.0.1, and 127.0.0.2, which every Linux machine has.
std::vector<in_addr_t> other_addresses() {
  std::vector<in_addr_t> found{INADDR_LOOPBACK + 1};
  ifaddrs* all = nullptr;
  EXPECT_EQ(::getifaddrs(&all), 0);
  for (const ifaddrs* one = all; one != nullptr; one = one->ifa_next) {
    if (one->ifa_addr != nullptr && one->ifa_addr->sa_family == AF_INET) {
      const in_addr_t address = ntohl(reinterpret_cast<const sockaddr_in*>(one->ifa_addr)->sin_addr.s_addr);
      if (address != INADDR_LOOPBACK) {
        found.push_back(address);
      }
    }
  }
  ::freeifaddrs(all);
  return found;
}

// Unsigned poses count there. Catches a port that is bound to all interfaces, or one that takes what a program of this
// machine passes on under an address of the network.
TEST(LoopbackPort, TakesPacketsOfTheLoopbackAloneWhateverAddressTheyComeFromOrGoTo) {
  free_descriptor_zero();
  const std::uint16_t number = free_port();
  UdpPort port(number, UdpReach::kLoopback);
  ASSERT_EQ(port.open(), core::Status::kOk);
  const Peer near;
  for (const in_addr_t address : other_addresses()) {
    const Peer other(address);
    other.send(number, "from another address");
    near.send(number, "to another address", address);
  }
  near.send(number, "near");
  std::array<std::byte, 100> bytes{};
  const core::Expected<std::size_t> count = port.read(bytes);
  ASSERT_TRUE(count);
  EXPECT_EQ(std::string(reinterpret_cast<const char*>(bytes.data()), *count), "near");
  EXPECT_EQ(*port.read(bytes), 0U) << "a packet of another address came in";
  UdpPort everywhere(free_port());
  ASSERT_EQ(everywhere.open(), core::Status::kOk) << "the check above must not hold for a reason of this machine";
}

TEST(UdpPortName, IsAPortNumberBehindUdp) {
  EXPECT_EQ(udp_port_of("udp:14550"), 14550);
  EXPECT_EQ(udp_port_of("udp:65535"), 65535);
  for (const char* const wrong :
       {"udp:", "udp:0", "udp:65536", "udp:-1", "udp:1x", "udp: 1", "14550", "/dev/ttyUSB0"}) {
    EXPECT_FALSE(udp_port_of(wrong)) << wrong;
  }
  EXPECT_TRUE(is_udp("udp:rubbish"));
  EXPECT_EQ(loopback_port_of("udp:127.0.0.1:14560"), 14560);
  for (const char* const wrong : {"udp:14560", "udp:127.0.0.1", "udp:127.0.0.1:", "udp:127.0.0.1:0", "udp:127.0.0.2:1",
                                  "udp:localhost:1", "udp:0.0.0.0:1"}) {
    EXPECT_FALSE(loopback_port_of(wrong)) << wrong;
  }
  EXPECT_FALSE(is_udp("sim:udp:1"));
}

}  // namespace
}  // namespace m100::hal
