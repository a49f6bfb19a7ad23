// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/crc.h"

#include "protocol/crc_kernels.h"

namespace m100::protocol {

std::uint16_t crc16(std::span<const std::byte> bytes, std::uint16_t state) {
  for (const std::byte byte : bytes) {
    state = static_cast<std::uint16_t>(
        crc_kernels::kTables16[0][(state ^ std::to_integer<std::uint16_t>(byte)) & 0xFFU] ^ (state >> 8U));
  }
  return state;
}

std::uint32_t crc32(std::span<const std::byte> bytes, std::uint32_t state) {
  const std::byte* next = bytes.data();
  std::size_t left = bytes.size();
  for (; left >= kCrc32BlockBytes; next += kCrc32BlockBytes, left -= kCrc32BlockBytes) {
    state = crc_kernels::step_block(state, next);
  }
  return crc_kernels::step_rest(state, next, left);
}

}  // namespace m100::protocol
