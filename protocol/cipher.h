// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace m100::protocol {

inline constexpr std::size_t kCipherBlockBytes = 16;
using CipherBlock = std::span<std::byte, kCipherBlockBytes>;
using CipherKey = std::array<std::uint8_t, 32>;

/// A block cipher with its key; the protocol uses AES-256 block by block without chaining (ECB).
/// A machine without AES has no cipher: every function that takes a cipher also accepts a null pointer.
class Cipher {
 public:
  Cipher() = default;
  Cipher(const Cipher&) = delete;
  Cipher& operator=(const Cipher&) = delete;
  /// Both work in place.
  virtual void encrypt(CipherBlock block) const = 0;
  virtual void decrypt(CipherBlock block) const = 0;

 protected:
  ~Cipher() = default;
};

}  // namespace m100::protocol
