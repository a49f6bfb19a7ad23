// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "firmware/core/time.h"

namespace m100::link {

/// How long so many bytes are on a line of 8N1. @param baud 0: no time at all.
constexpr core::Duration line_time(std::uint64_t bytes, std::uint32_t baud) {
  constexpr std::uint64_t kBitsPerByte = 10;
  return core::Duration{
      baud == 0 ? 0 : static_cast<core::Duration::rep>(bytes * kBitsPerByte * std::uint64_t{1000000} / baud)};
}

}  // namespace m100::link
