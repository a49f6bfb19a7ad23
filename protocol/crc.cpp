// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/crc.h"

#include "protocol/crc_table.h"

namespace m100::protocol {
namespace {

constexpr auto kTable16 = make_crc_table<std::uint16_t>(0xA001);
constexpr auto kTable32 = make_crc_table<std::uint32_t>(0xEDB88320);

}  // namespace

std::uint16_t crc16(std::span<const std::byte> bytes, std::uint16_t state) {
  return static_cast<std::uint16_t>(continue_crc(kTable16, state, bytes));
}

std::uint32_t crc32(std::span<const std::byte> bytes, std::uint32_t state) {
  return continue_crc(kTable32, state, bytes);
}

}  // namespace m100::protocol
