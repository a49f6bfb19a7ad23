// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <span>

#include "firmware/core/expected.h"

namespace m100::hal {

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

 protected:
  Uart() = default;
  ~Uart() = default;
};

}  // namespace m100::hal
