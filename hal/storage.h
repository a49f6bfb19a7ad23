// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <span>

#include "firmware/core/expected.h"

namespace m100::hal {

/// The medium of a flight log: bytes are appended and never read back. A call may block for as long as the medium
/// takes, so the tick writes into a ring, and another thread empties the ring into the storage.
class Storage {
 public:
  Storage(const Storage&) = delete;
  Storage& operator=(const Storage&) = delete;

  /// @returns how many bytes from the front of source were taken; fewer than source.size(): try the rest later.
  ///   kResourceExhausted: the medium is full.
  ///   kUnavailable: the medium was removed or failed.
  virtual core::Expected<std::size_t> append(std::span<const std::byte> source) = 0;

  /// Makes everything appended so far survive a loss of power.
  /// @returns kOk, or kUnavailable.
  virtual core::Status sync() = 0;

 protected:
  Storage() = default;
  ~Storage() = default;
};

}  // namespace m100::hal
