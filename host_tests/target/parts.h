// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

// Measures the cycles of the system timer that each part of a tick takes, in the object code of the flight program
// itself. The linker routes the calls between its files through trampolines (--wrap) that read the timer and change
// nothing else.
namespace m100::target {

inline constexpr std::size_t kParts = 12;
inline constexpr std::array<std::string_view, kParts> kPartNames{
#define M100_PART(number, name) name,
#define M100_PROBE(number, symbol)
#include "host_tests/target/parts.inc"
#undef M100_PART
#undef M100_PROBE
};

/// Begins to count. A call into another part is counted for that other part.
void begin_parts();
/// Ends the count. @returns the cycles of each part since begin_parts().
const std::array<std::uint32_t, kParts>& end_parts();

}  // namespace m100::target
