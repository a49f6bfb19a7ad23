// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

// How many cycles of the system timer each part of a tick takes, measured in the flight program's own object code: the
// linker leads the calls between its files through trampolines (--wrap) that read the timer and change nothing else.
namespace m100::target {

inline constexpr std::size_t kParts = 12;
inline constexpr std::array<std::string_view, kParts> kPartNames{
#define M100_PART(number, name) name,
#define M100_PROBE(number, symbol)
#include "host_tests/target/parts.inc"
#undef M100_PART
#undef M100_PROBE
};

/// Begins to count. What a part calls of another one counts for the other.
void begin_parts();
/// Ends it. @returns the cycles of each part since begin_parts().
const std::array<std::uint32_t, kParts>& end_parts();

}  // namespace m100::target
