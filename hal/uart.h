// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/core/expected.h"

namespace m100::hal {

/// What a receiver has seen go wrong on its line, counted since the port was first opened; each count wraps. A wrong
/// baud rate breaks the frames of many bytes; noise breaks those of a few; a line that is held low is one long break.
struct LineErrors {
  std::uint32_t framing = 0;  ///< bytes without a stop bit where one must be
  std::uint32_t parity = 0;   ///< bytes whose parity is wrong (0 at 8N1, unless the other side sends a parity bit)
  std::uint32_t overrun = 0;  ///< bytes that came before there was room for them
  std::uint32_t breaks = 0;   ///< times that the line was low for longer than a byte

  friend bool operator==(const LineErrors&, const LineErrors&) = default;
};

/// A byte stream to another machine: 8 data bits, no parity, 1 stop bit, no flow control, both directions independent.
///
/// Nothing here ever blocks. Bytes may arrive damaged, late, doubled or not at all: the callers' checksums find out.
/// Called from one thread; an implementation that works in an interrupt keeps its own rings.
class Uart {
 public:
  Uart(const Uart&) = delete;
  Uart& operator=(const Uart&) = delete;

  /// Takes what has arrived, oldest first, at most destination.size() bytes.
  /// @returns how many bytes were written to destination; 0: nothing has come.
  ///   kUnavailable: the device is gone. Go on calling: it may come back, and then bytes come again.
  virtual core::Expected<std::size_t> read(std::span<std::byte> destination) = 0;

  /// Hands over bytes to send, as many as there is room for.
  /// @returns how many bytes from the front of source were taken; fewer than source.size(), even 0: full, the rest is
  ///   still the caller's.
  ///   kUnavailable: the device is gone; nothing was taken.
  virtual core::Expected<std::size_t> write(std::span<const std::byte> source) = 0;

  /// What has gone wrong on the line. Costs a system call where there is an operating system: not for every tick.
  /// @returns the counts; a kind that the device cannot notice stays 0.
  ///   kUnavailable: this device counts nothing (a pseudo-terminal, a recorded flight), or it is gone.
  virtual core::Expected<LineErrors> line_errors() const { return core::Status::kUnavailable; }

 protected:
  Uart() = default;
  ~Uart() = default;
};

}  // namespace m100::hal
