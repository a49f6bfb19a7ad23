// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace m100::hal {

/// The bytes that a UART at receiver_baud receives of bytes sent back to back at sender_baud. The waveform (start bit
/// 0, eight data bits from the lowest, stop bit 1) is sampled in the middle of each of the receiver's bit times,
/// from each falling edge. Bytes whose stop bit reads 0 (a framing error) are kept if keep_framing_errors, as on Linux.
std::vector<std::byte> received_at(std::span<const std::byte> sent, std::uint32_t sender_baud,
                                   std::uint32_t receiver_baud, bool keep_framing_errors = true);

}  // namespace m100::hal
