// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "firmware/core/time.h"

namespace m100::link {

/// How long so many bytes are on a line of 8N1. @param baud 0: no time at all.
constexpr core::Duration line_time(std::uint64_t bytes, std::uint32_t baud) {
  constexpr std::uint32_t kAtOneBaud_us = 10 * 1000000;  // what a byte of ten bits takes at one bit a second
  if (baud == 0) {
    return core::Duration{0};
  }
  // The same number either way; what one tick reads fits into 32 bits, beyond that a library function divides.
  constexpr std::uint64_t kShort = 0xFFFFFFFFU / kAtOneBaud_us;
  return core::Duration{bytes <= kShort ? static_cast<std::uint32_t>(bytes) * kAtOneBaud_us / baud
                                        : static_cast<core::Duration::rep>(bytes * kAtOneBaud_us / baud)};
}

}  // namespace m100::link
