// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <arpa/inet.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <system_error>
#include <vector>

#include "hal/linux/descriptor.h"

namespace m100::sim {

/// A UDP socket of this machine with a free port, by default on 127.0.0.1.
class LoopbackSocket {
 public:
  /// @throws std::system_error: there is no free port, or no such address.
  explicit LoopbackSocket(in_addr_t own = INADDR_LOOPBACK) : socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address = at(own, 0);
    socklen_t size = sizeof(address);
    if (::bind(socket_.number, reinterpret_cast<const sockaddr*>(&address), size) != 0 ||
        ::getsockname(socket_.number, reinterpret_cast<sockaddr*>(&address), &size) != 0) {
      throw std::system_error(errno, std::generic_category(), "no UDP port");
    }
    port_ = ntohs(address.sin_port);
  }
  std::uint16_t port() const { return port_; }
  int number() const { return socket_.number; }  ///< its descriptor
  void send(std::uint16_t to, std::span<const std::byte> packet) const {
    const sockaddr_in address = at(INADDR_LOOPBACK, to);
    (void)!::sendto(socket_.number, packet.data(), packet.size(), 0, reinterpret_cast<const sockaddr*>(&address),
                    sizeof(address));
  }
  /// @returns the next packet; empty if none is waiting.
  std::optional<std::vector<std::byte>> receive() const {
    std::vector<std::byte> packet(2000);
    const ssize_t count = ::recv(socket_.number, packet.data(), packet.size(), MSG_DONTWAIT);
    if (count < 0) {
      return {};
    }
    packet.resize(static_cast<std::size_t>(count));
    return packet;
  }

 private:
  static sockaddr_in at(in_addr_t host, std::uint16_t port) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(host);
    return address;
  }
  hal::Descriptor socket_;
  std::uint16_t port_ = 0;
};

}  // namespace m100::sim
