// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <span>

#include "firmware/core/expected.h"

namespace m100::hal {

/// Where a flight log goes: bytes are appended and never read back. May block for as long as the medium likes, so the
/// tick writes into a ring and something else empties the ring into here.
class Storage {
 public:
  Storage(const Storage&) = delete;
  Storage& operator=(const Storage&) = delete;

  /// @returns how many bytes from the front of source were taken; fewer than source.size(): try the rest later.
  ///   kResourceExhausted: the medium is full.
  ///   kUnavailable: the medium is gone or failed.
  virtual core::Expected<std::size_t> append(std::span<const std::byte> source) = 0;

  /// Makes everything appended so far survive a loss of power.
  /// @returns kOk, or kUnavailable.
  virtual core::Status sync() = 0;

 protected:
  Storage() = default;
  ~Storage() = default;
};

}  // namespace m100::hal
