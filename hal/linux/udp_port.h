// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <netinet/in.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "hal/linux/descriptor.h"
#include "hal/packet_uart.h"

namespace m100::hal {

/// The port in "udp:PORT", 1 to 65535. @returns nullopt: the name does not have this form.
std::optional<std::uint16_t> udp_port_of(std::string_view name);
/// The port in "udp:127.0.0.1:PORT", for packets of this machine alone. @returns nullopt: another form.
std::optional<std::uint16_t> loopback_port_of(std::string_view name);
constexpr bool is_udp(std::string_view name) { return name.substr(0, 4) == "udp:"; }

/// Whose packets a UDP port takes; kLoopback: those that programs of this machine send from 127.0.0.1.
enum class UdpReach : std::uint8_t { kNetwork, kLoopback };

/// A UDP port of this machine, IPv4, all interfaces or the loopback alone, non-blocking. Its bytes are those of the
/// packets in their order of arrival; a packet that is longer than kMaxPacketBytes, or empty, is skipped.
///
/// Unread packets are limited to kWaitingBytes of the kernel's memory: a flood loses packets instead of delaying
/// them. Before answer_last() there is no peer, and written bytes are lost. Allocates nothing.
class UdpPort final : public PacketUart {
 public:
  static constexpr std::size_t kMaxPacketBytes = 1500;
  static constexpr int kWaitingBytes = 1 << 16;

  explicit UdpPort(std::uint16_t port, UdpReach reach = UdpReach::kNetwork) : port_(port), reach_(reach) {}

  /// @returns kOk; kRefused: no right, or another program has it; kUnavailable: the machine has no network.
  core::Status open();

  /// As SerialPort::mark_arrived(): packets that come later, by the kernel's stamps, are read only after the next mark.
  void mark_arrived();
  core::Expected<std::size_t> read(std::span<std::byte> destination) override;
  core::Expected<std::size_t> write(std::span<const std::byte> source) override;
  bool begins_packet() const override { return at_begin_; }
  void answer_last() override;

  /// Sends one packet to the peer, from any thread. @returns false: there is no peer, or the packet did not leave.
  bool send(std::span<const std::byte> packet) const;

 private:
  /// Receives the next usable packet. @returns false: none has come before the mark, or too many in a row were skipped.
  bool receive();

  /// Whether the packet that came last may be used.
  bool is_usable(std::size_t bytes) const;

  std::uint16_t port_;
  UdpReach reach_;
  Descriptor descriptor_;
  std::array<std::byte, kMaxPacketBytes> packet_{};
  std::span<const std::byte> rest_;
  std::int64_t mark_ns_ = 0;    ///< of the machine's wall clock, as the kernel's stamps are; 0: not marked
  bool is_after_mark_ = false;  ///< the packet in rest_
  bool at_begin_ = false;
  sockaddr_in last_{};
  std::atomic<std::uint64_t> peer_{0};  ///< address and port in network byte order; 0: no peer
};

}  // namespace m100::hal
