// SPDX-License-Identifier: BSD-3-Clause
#include "hal/linux/udp_port.h"

#include <arpa/inet.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cstring>

namespace m100::hal {
namespace {

constexpr std::string_view kUdp = "udp:";
constexpr std::string_view kLoopback = "udp:127.0.0.1:";

/// Largest number of unusable packets, and of interruptions, that one call skips.
constexpr int kPassedOver = 16;

std::int64_t nanoseconds(const timespec& time) {
  return (std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec)).count();
}

/// When the kernel received the packet. @returns 0: it has no stamp.
std::int64_t arrival_ns(msghdr& message) {
  for (cmsghdr* part = CMSG_FIRSTHDR(&message); part != nullptr; part = CMSG_NXTHDR(&message, part)) {
    if (part->cmsg_level == SOL_SOCKET && part->cmsg_type == SCM_TIMESTAMPNS) {
      timespec stamp{};
      std::memcpy(&stamp, CMSG_DATA(part), sizeof(stamp));
      return nanoseconds(stamp);
    }
  }
  return 0;
}

/// @returns nullopt: what follows the prefix is no port.
std::optional<std::uint16_t> port_after(std::string_view prefix, std::string_view name) {
  if (!name.starts_with(prefix)) {
    return {};
  }
  const std::string_view digits = name.substr(prefix.size());
  std::uint16_t port = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), port);
  const bool is_number = error == std::errc{} && end == digits.data() + digits.size();
  return is_number && port > 0 ? std::optional(port) : std::nullopt;
}

}  // namespace

std::optional<std::uint16_t> udp_port_of(std::string_view name) { return port_after(kUdp, name); }
std::optional<std::uint16_t> loopback_port_of(std::string_view name) { return port_after(kLoopback, name); }

core::Status UdpPort::open() {
  descriptor_ = Descriptor(::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (descriptor_.number < 0) {
    return core::Status::kUnavailable;
  }
  (void)::setsockopt(descriptor_.number, SOL_SOCKET, SO_RCVBUF, &kWaitingBytes, sizeof(kWaitingBytes));
  const int with_stamps = 1;
  (void)::setsockopt(descriptor_.number, SOL_SOCKET, SO_TIMESTAMPNS, &with_stamps, sizeof(with_stamps));
  sockaddr_in address{};
  address.sin_addr.s_addr = htonl(reach_ == UdpReach::kLoopback ? INADDR_LOOPBACK : INADDR_ANY);
  address.sin_family = AF_INET;
  address.sin_port = htons(port_);
  if (::bind(descriptor_.number, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0) {
    const bool not_ours = errno == EADDRINUSE || errno == EACCES;
    descriptor_ = Descriptor();
    return not_ours ? core::Status::kRefused : core::Status::kUnavailable;
  }
  return core::Status::kOk;
}

void UdpPort::mark_arrived() {
  timespec now{};
  ::clock_gettime(CLOCK_REALTIME, &now);
  mark_ns_ = nanoseconds(now);
  is_after_mark_ = false;
}

// A program of this machine may send from any of its addresses, also for somebody else: only the loopback's counts.
bool UdpPort::is_usable(std::size_t bytes) const {
  const bool is_allowed = reach_ == UdpReach::kNetwork || last_.sin_addr.s_addr == htonl(INADDR_LOOPBACK);
  return bytes > 0 && bytes <= packet_.size() && is_allowed;
}

bool UdpPort::receive() {
  for (int packet = 0; packet < kPassedOver; ++packet) {
    iovec data{.iov_base = packet_.data(), .iov_len = packet_.size()};
    alignas(cmsghdr) std::array<std::byte, CMSG_SPACE(sizeof(timespec))> control{};
    msghdr message{};
    message.msg_name = &last_;
    message.msg_namelen = sizeof(last_);
    message.msg_iov = &data;
    message.msg_iovlen = 1;
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    const ssize_t count = ::recvmsg(descriptor_.number, &message, MSG_TRUNC);
    if (count < 0 && errno != EINTR) {
      return false;
    }
    if (count > 0 && is_usable(static_cast<std::size_t>(count))) {
      rest_ = std::span(packet_).first(static_cast<std::size_t>(count));
      is_after_mark_ = mark_ns_ != 0 && arrival_ns(message) > mark_ns_;
      return !is_after_mark_;
    }
  }
  return false;
}

core::Expected<std::size_t> UdpPort::read(std::span<std::byte> destination) {
  if (descriptor_.number < 0) {
    return core::Status::kUnavailable;
  }
  at_begin_ = rest_.empty() || rest_.data() == packet_.data();
  if (is_after_mark_ || (rest_.empty() && !receive())) {
    return std::size_t{0};
  }
  const std::span<const std::byte> now = rest_.first(std::min(rest_.size(), destination.size()));
  std::copy(now.begin(), now.end(), destination.begin());
  rest_ = rest_.subspan(now.size());
  return now.size();
}

void UdpPort::answer_last() { peer_ = (static_cast<std::uint64_t>(last_.sin_addr.s_addr) << 16U) | last_.sin_port; }

bool UdpPort::send(std::span<const std::byte> packet) const {
  const std::uint64_t peer = peer_;
  if (peer == 0) {
    return false;
  }
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = static_cast<in_port_t>(peer & 0xFFFFU);
  address.sin_addr.s_addr = static_cast<in_addr_t>(peer >> 16U);
  return ::sendto(descriptor_.number, packet.data(), packet.size(), MSG_NOSIGNAL,
                  reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == static_cast<ssize_t>(packet.size());
}

core::Expected<std::size_t> UdpPort::write(std::span<const std::byte> source) {
  if (descriptor_.number < 0) {
    return core::Status::kUnavailable;
  }
  (void)send(source);  // a packet that does not leave is lost, as on a network
  return source.size();
}

}  // namespace m100::hal
