// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/bridge/sender.h"

#include <arpa/inet.h>
#include <sys/socket.h>

#include <algorithm>
#include <chrono>
#include <span>

#include "hal/linux/udp_port.h"
#include "host_tests/lab/input_error.h"

namespace m100::lab::bridge {
namespace {

constexpr std::uint8_t kLink = 1;

sockaddr_in address_of(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  const std::string host = text.substr(0, colon);
  const auto port = hal::udp_port_of("udp:" + (colon == std::string::npos ? "" : text.substr(colon + 1)));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  if (!port || inet_pton(AF_INET, host.c_str(), &address.sin_addr) != 1) {
    throw InputError("--to", 0, "", text + " is not an IPv4 address and port, such as 127.0.0.1:14560");
  }
  address.sin_port = htons(*port);
  return address;
}

/// The machine's wall-clock time, in signature ticks of 10 us since 2015.
mavlink::SignatureTime calendar() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  const auto ticks = std::chrono::duration_cast<std::chrono::microseconds>(now).count() / 10 -
                     mavlink::kSignatureEpoch_s * static_cast<std::int64_t>(mavlink::kSignatureTicksPerSecond);
  return static_cast<mavlink::SignatureTime>(std::max<std::int64_t>(ticks, 0));
}

}  // namespace

Sender::Sender(const std::string& to, const mavlink::Key& key)
    : key_(key), to_(address_of(to)), socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)) {
  if (socket_.number < 0) {
    throw InputError("--to", 0, "", "this machine has no network");
  }
}

bool Sender::sign_and_send(mavlink::Frame frame) {
  stamp_ = std::max(stamp_ + 1, calendar());
  mavlink::sign(frame, key_, kLink, stamp_);
  const std::span<const std::byte> bytes = frame.bytes();
  return ::sendto(socket_.number, bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&to_),
                  sizeof(to_)) == static_cast<ssize_t>(bytes.size());
}

}  // namespace m100::lab::bridge
