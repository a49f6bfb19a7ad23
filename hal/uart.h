// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/core/expected.h"

namespace m100::hal {

/// The errors that a receiver has detected on its line, counted since the port was first opened; each count wraps. A
/// wrong baud rate causes framing errors in many bytes, noise in a few; a line that is held low is one long break.
struct LineErrors {
  std::uint32_t framing = 0;  ///< bytes without a stop bit where one must be
  std::uint32_t parity = 0;   ///< bytes whose parity is wrong (0 at 8N1, unless the other side sends a parity bit)
  std::uint32_t overrun = 0;  ///< bytes that came before there was room for them
  std::uint32_t breaks = 0;   ///< times that the line was low for longer than a byte

  friend bool operator==(const LineErrors&, const LineErrors&) = default;
};

/// A byte stream to another machine: 8 data bits, no parity, 1 stop bit, no flow control, both directions independent.
///
/// No call blocks. Bytes may arrive damaged, late, duplicated or not at all: the callers detect this by checksums.
/// Called from one thread; an implementation that uses interrupts has its own rings.
class Uart {
 public:
  Uart(const Uart&) = delete;
  Uart& operator=(const Uart&) = delete;

  /// Reads the bytes that have arrived, oldest first, at most destination.size().
  /// @returns how many bytes were written to destination; 0: none has arrived.
  ///   kUnavailable: the device is missing. Continue to call: it may come back, and then bytes arrive again.
  virtual core::Expected<std::size_t> read(std::span<std::byte> destination) = 0;

  /// Queues bytes for sending, as many as there is room for.
  /// @returns how many bytes from the front of source were taken; fewer than source.size(), even 0: full, the caller
  ///   keeps the rest.
  ///   kUnavailable: the device is missing; nothing was taken.
  virtual core::Expected<std::size_t> write(std::span<const std::byte> source) = 0;

  /// The errors on the line so far. Costs a system call where there is an operating system: do not call it every tick.
  /// @returns the counts; the count of an error that the device cannot detect stays 0.
  ///   kUnavailable: this device counts no errors (a pseudo-terminal, a recorded flight), or it is missing.
  virtual core::Expected<LineErrors> line_errors() const { return core::Status::kUnavailable; }

 protected:
  Uart() = default;
  ~Uart() = default;
};

}  // namespace m100::hal
