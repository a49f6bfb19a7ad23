// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>

#include "protocol/cipher.h"

namespace m100::protocol {

/// AES-256 by mbedTLS (target m100::aes; machines without that library leave the target out).
/// Holds both key schedules; no heap. Cost: two key expansions at construction, one block operation per call.
class Aes256 final : public Cipher {
 public:
  explicit Aes256(const CipherKey& key);
  void encrypt(CipherBlock block) const override;
  void decrypt(CipherBlock block) const override;

 private:
  /// Room for an mbedtls_aes_context, whose header stays out of ours; aes256.cpp checks size and alignment.
  struct alignas(std::max_align_t) Schedule {
    std::array<std::byte, 320> bytes{};
  };
  mutable Schedule encryption_;  // mbedTLS takes a pointer to non-const, but writes nothing
  mutable Schedule decryption_;
};

}  // namespace m100::protocol
