// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "hal/uart.h"

namespace m100::sim {

/// The autopilot's end of a pseudo-terminal; a client opens the other end by the name of a symbolic link as if it were
/// a serial port. The line is raw before the client comes, so nothing is echoed or translated. Not paced: that is
/// N1Line's.
///
/// A pseudo-terminal carries bytes, not bits, but it knows the rate that its client asked for: where that differs from
/// ours, both directions are re-sampled as two UARTs at different rates would read each other.
class PtyUart final : public hal::Uart {
 public:
  /// @throws std::runtime_error: no pseudo-terminal, or the link cannot be made. An existing symbolic link is replaced;
  /// anything else of that name is not.
  /// @param baud our own rate; 0: none, nothing is ever garbled.
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
  int master_ = -1;
  int slave_ = -1;  ///< kept open, so that a client who leaves does not hang up the line
};

}  // namespace m100::sim
