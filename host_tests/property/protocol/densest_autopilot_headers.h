// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace m100::host_tests {

/// The costliest bytes for a parser that admits the frames of an autopilot (kMaxAutopilotFrameBytes), repeated without
/// end: every eighth byte begins a header with a valid CRC16, which is LEN and SESSION of the next one. They claim 144
/// bytes in the mean; a search through all chains of headers found none above 145.
inline constexpr std::array<std::uint8_t, 16> kDensestAutopilotHeaders{0xAA, 128, 0, 31, 118, 0, 0, 0,
                                                                       0xAA, 160, 0, 7,  118, 0, 0, 0};

constexpr std::byte densest_autopilot_byte(std::size_t at) {
  return static_cast<std::byte>(kDensestAutopilotHeaders[at % kDensestAutopilotHeaders.size()]);
}

}  // namespace m100::host_tests
