// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "firmware/core/time.h"

namespace m100::link {

/// Time that this many bytes take on an 8N1 line. @param baud 0: no time.
constexpr core::Duration line_time(std::uint64_t bytes, std::uint32_t baud) {
  constexpr std::uint32_t kAtOneBaud_us = 10 * 1000000;  // what a byte of ten bits takes at one bit a second
  if (baud == 0) {
    return core::Duration{0};
  }
  // Both divisions give the same number; up to 429 bytes (18 ms at 230400 baud) no library function is needed.
  constexpr std::uint64_t kShort = 0xFFFFFFFFU / kAtOneBaud_us;
  return core::Duration{bytes <= kShort ? static_cast<std::uint32_t>(bytes) * kAtOneBaud_us / baud
                                        : static_cast<core::Duration::rep>(bytes * kAtOneBaud_us / baud)};
}

}  // namespace m100::link
