// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "firmware/core/assert.h"
#include "protocol/bytes.h"

namespace m100::protocol {

/// The value bytes of one message: the bytes after set and id, or the whole DATA of an acknowledgement.
/// Large enough for every message that this project sends (longest: telemetry, 124).
class Value {
 public:
  static constexpr std::size_t kCapacity = 128;

  Value() = default;
  /// Makes a value of the bytes that `write` puts into the ByteWriter it receives. M100_ASSERT checks the capacity.
  template <typename Write>
  static Value of(Write&& write) {
    Value value;
    ByteWriter writer(value.bytes_);
    write(writer);
    M100_ASSERT(writer.ok());
    value.size_ = writer.size();
    return value;
  }

  std::span<const std::byte> bytes() const { return std::span(bytes_).first(size_); }
  operator std::span<const std::byte>() const { return bytes(); }  // NOLINT: a Value is its bytes
  std::size_t size() const { return size_; }

 private:
  std::array<std::byte, kCapacity> bytes_{};
  std::size_t size_ = 0;
};

}  // namespace m100::protocol
