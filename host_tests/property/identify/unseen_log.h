// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host_tests/property/identify/adversarial_log.h"

namespace m100::host_tests {

// Logs of vehicles, pilots, air, clocks and loggers that are drawn at random from wide ranges. They are written as rows
// and read by the log reader, like a file. Roll, pitch or climb; 50 to 90 s; 10 to 400 Hz; sticks of a pilot, sums of
// sines, doublets, holds, bang-bang, a closed loop; rounding, uneven time stamps; one split, or pieces of 6 s.

/// The kinds, in the order of the published table; names of healthy kinds begin with "healthy".
const std::vector<std::string>& unseen_log_kinds();
/// @param kind  one of unseen_log_kinds()
AdversarialLog unseen_log(const std::string& kind, std::uint64_t seed);

}  // namespace m100::host_tests
