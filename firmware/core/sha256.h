// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace m100::core {

using Sha256Digest = std::array<std::uint8_t, 32>;

/// SHA-256 (FIPS 180-4) over bytes that arrive in pieces. Constant memory; no library.
class Sha256 {
 public:
  void update(std::span<const std::byte> bytes);
  /// The digest of all bytes so far; the object must not be used afterwards.
  Sha256Digest finish();

 private:
  void block(const std::uint8_t* data);
  std::array<std::uint32_t, 8> state_{0x6a09e667U, 0xbb67ae85U, 0x3c6ef372U, 0xa54ff53aU,
                                      0x510e527fU, 0x9b05688cU, 0x1f83d9abU, 0x5be0cd19U};
  std::array<std::uint8_t, 64> pending_{};
  std::uint64_t length_bytes_ = 0;
};

/// The digest of one contiguous range of bytes.
Sha256Digest sha256(std::span<const std::byte> bytes);

/// 64 lower-case hexadecimal digits.
std::array<char, 64> hex(const Sha256Digest& digest);

}  // namespace m100::core
