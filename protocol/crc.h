// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace m100::protocol {

/// Register contents before the first byte; both checksums start from the same unusual number (DJI's choice).
inline constexpr std::uint16_t kCrc16Start = 0x3AA3;
inline constexpr std::uint32_t kCrc32Start = 0x00003AA3;

/// CRC-16, polynomial 0x8005 reflected (0xA001), no final XOR. The bytes of a header followed by its own CRC give 0.
/// Cost: 1 table look-up per byte.
std::uint16_t crc16(std::span<const std::byte> bytes, std::uint16_t state = kCrc16Start);

/// CRC-32, polynomial 0x04C11DB7 reflected (0xEDB88320), no final XOR. A frame with its own CRC gives 0.
/// Cost: 1 table look-up per byte.
std::uint32_t crc32(std::span<const std::byte> bytes, std::uint32_t state = kCrc32Start);

}  // namespace m100::protocol
