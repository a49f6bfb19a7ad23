// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/bridge/vrpn_source.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>

#include <array>
#include <optional>
#include <span>

#include "hal/linux/udp_port.h"
#include "host_tests/lab/input_error.h"

namespace m100::lab::bridge {
namespace {

constexpr int kTries = 10;  ///< a second each

[[noreturn]] void fail(const VrpnName& name, const std::string& what) {
  throw InputError("--vrpn", 0, "", name.tracker + "@" + name.host + ":" + std::to_string(name.port) + ": " + what);
}

/// This machine's address on the route to the server, as text.
std::string own_address(int socket) {
  sockaddr_in own{};
  socklen_t size = sizeof(own);
  std::array<char, INET_ADDRSTRLEN> text{};
  (void)::getsockname(socket, reinterpret_cast<sockaddr*>(&own), &size);
  return inet_ntop(AF_INET, &own.sin_addr, text.data(), text.size()) == nullptr ? "" : text.data();
}

}  // namespace

VrpnName vrpn_name(const std::string& text) {
  const std::size_t at = text.find('@');
  VrpnName name;
  name.tracker = text.substr(0, at);
  name.host = at == std::string::npos ? "" : text.substr(at + 1);
  if (const std::size_t colon = name.host.find(':'); colon != std::string::npos) {
    const std::optional<std::uint16_t> port = hal::udp_port_of("udp:" + name.host.substr(colon + 1));
    name.host.resize(colon);
    name.port = port.value_or(0);
  }
  in_addr address{};
  if (name.tracker.empty() || name.port == 0 || inet_pton(AF_INET, name.host.c_str(), &address) != 1) {
    throw InputError("--vrpn", 0, "", text + " is not TRACKER@HOST or TRACKER@HOST:PORT, HOST an IPv4 address");
  }
  return name;
}

hal::Descriptor connect(const VrpnName& name) {
  sockaddr_in server{};
  server.sin_family = AF_INET;
  server.sin_port = htons(name.port);
  (void)inet_pton(AF_INET, name.host.c_str(), &server.sin_addr);  // vrpn_name() has checked it
  const hal::Descriptor asks(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  const hal::Descriptor waits(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  sockaddr_in any{};
  any.sin_family = AF_INET;
  socklen_t size = sizeof(any);
  if (::connect(asks.number, reinterpret_cast<const sockaddr*>(&server), sizeof(server)) != 0 ||
      ::bind(waits.number, reinterpret_cast<const sockaddr*>(&any), sizeof(any)) != 0 ||
      ::listen(waits.number, 1) != 0 || ::getsockname(waits.number, reinterpret_cast<sockaddr*>(&any), &size) != 0) {
    fail(name, "this machine has no route to it");
  }
  const std::string request = own_address(asks.number) + " " + std::to_string(ntohs(any.sin_port));
  for (int i = 0; i < kTries; ++i) {
    (void)!::send(asks.number, request.c_str(), request.size() + 1, 0);  // with its zero
    pollfd came{.fd = waits.number, .events = POLLIN, .revents = 0};
    if (::poll(&came, 1, 1000) > 0) {
      hal::Descriptor connection(::accept4(waits.number, nullptr, nullptr, SOCK_CLOEXEC));
      const std::array<std::byte, kVrpnCookieBytes> cookie = vrpn_cookie();
      if (::send(connection.number, cookie.data(), cookie.size(), MSG_NOSIGNAL) ==
          static_cast<ssize_t>(cookie.size())) {
        return connection;
      }
    }
  }
  fail(name, "no server answered");
}

bool read(const hal::Descriptor& connection, VrpnStream& stream, const VrpnStream::Use& use) {
  std::array<std::byte, 4096> bytes{};
  for (;;) {  // until nothing waits
    const ssize_t size = ::recv(connection.number, bytes.data(), bytes.size(), MSG_DONTWAIT);
    if (size < 0) {
      return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR;
    }
    if (size == 0 || !stream.consume(std::span<const std::byte>(bytes).first(static_cast<std::size_t>(size)), use)) {
      return false;
    }
  }
}

}  // namespace m100::lab::bridge
