// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "hal/mock/manual_clock.h"
#include "hal/mock/uart_pair.h"

namespace m100::hal {

/// Bytes whose values are their positions: 0, 1, 2 and so on.
inline std::vector<std::byte> counting(std::size_t size) {
  std::vector<std::byte> bytes(size);
  for (std::size_t i = 0; i < size; ++i) {
    bytes[i] = static_cast<std::byte>(i);
  }
  return bytes;
}

inline std::vector<std::byte> read_all(Uart& uart) {
  std::vector<std::byte> all;
  std::array<std::byte, 512> chunk;
  while (true) {
    const core::Expected<std::size_t> count = uart.read(chunk);
    if (!count || *count == 0) {
      return all;
    }
    all.insert(all.end(), chunk.begin(), chunk.begin() + static_cast<std::ptrdiff_t>(*count));
  }
}

}  // namespace m100::hal
