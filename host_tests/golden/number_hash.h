// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <string_view>
#include <type_traits>

#include "firmware/core/sha256.h"

namespace m100::golden {

/// 64 hexadecimal digits.
using HashText = std::array<char, 64>;

/// SHA-256 over the bits of numbers, so that 0 and -0 differ. Two machines compare it to prove that they computed the
/// same (promise R6). All supported machines store numbers least significant byte first.
class NumberHash {
 public:
  template <typename T>
  void append(T number) {
    static_assert(std::is_arithmetic_v<T> && std::endian::native == std::endian::little);
    hash_.update(std::bit_cast<std::array<std::byte, sizeof(T)>>(number));
  }
  HashText finish() { return core::hex(hash_.finish()); }

 private:
  core::Sha256 hash_;
};

inline std::string_view view(const HashText& text) { return {text.data(), text.size()}; }

}  // namespace m100::golden
