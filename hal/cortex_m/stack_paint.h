// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace m100::hal {

/// Start-up fills the stack with this word; words that differ from it later have been used (promise R8).
inline constexpr std::uint32_t kStackPaint = 0xC5C5C5C5U;

/// Deepest use of the stack since reset, interrupts included, in bytes. Scans the unused part: not for the tick.
std::uint32_t deepest_stack_bytes();
std::uint32_t reserved_stack_bytes();

}  // namespace m100::hal
