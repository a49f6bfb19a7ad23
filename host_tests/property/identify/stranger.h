// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host_tests/property/identify/adversary.h"

namespace m100::host_tests {

// Logs of strangers: vehicles, hands, air, clocks and loggers drawn at random from wide ranges, written as rows and
// read by the reader of logs, as a file would be. Roll, pitch or climb; 50 to 90 s; 10 to 400 Hz; sticks of a pilot,
// sums of sines, doublets, holds, bang-bang, a closed loop; rounding, uneven stamps; one split or pieces of 6 s in
// turn.

/// The kinds, in the order of the published table; a name that begins with "healthy" is one.
const std::vector<std::string>& stranger_kinds();
/// @param kind  one of stranger_kinds()
Adversary stranger(const std::string& kind, std::uint64_t seed);

}  // namespace m100::host_tests
