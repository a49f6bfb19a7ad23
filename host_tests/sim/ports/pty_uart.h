// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "hal/linux/descriptor.h"
#include "hal/uart.h"

namespace m100::sim {

/// The autopilot's end of a pseudo-terminal. A client opens the other end by the name of a symbolic link, like a serial
/// port. The line is raw before the client opens it, so nothing is echoed or translated. N1Line does the pacing.
///
/// A pseudo-terminal carries bytes, not bits, but it knows the rate that its client has set. If that differs from ours,
/// both directions are re-sampled as two UARTs at different rates would read each other.
class PtyUart final : public hal::Uart {
 public:
  /// @throws std::runtime_error: no pseudo-terminal, or the link cannot be made. An existing symbolic link is replaced;
  /// anything else of that name is not.
  /// @param baud our own rate; 0: none, bytes are never re-sampled.
  explicit PtyUart(std::string link, std::uint32_t baud = 0);
  ~PtyUart();

  core::Expected<std::size_t> read(std::span<std::byte> destination) override;
  core::Expected<std::size_t> write(std::span<const std::byte> source) override;
  const std::string& link() const { return link_; }
  /// The rate the client has set; ours until it sets one, 0 for a rate that no SerialPort asks for.
  std::uint32_t clients_baud() const;

 private:
  bool rates_differ(std::uint32_t clients) const { return baud_ != 0 && clients != 0 && clients != baud_; }

  std::string link_;
  std::uint32_t baud_;
  hal::Descriptor master_;
  hal::Descriptor slave_;  ///< kept open, so that a client that closes its end does not hang up the line
};

}  // namespace m100::sim
