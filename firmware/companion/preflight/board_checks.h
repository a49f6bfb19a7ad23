// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "firmware/companion/preflight/check_result.h"

namespace m100::companion::preflight {

// Checks of what the board itself may lack for a flight. Each looks once, changes nothing, and names the remedy.

inline constexpr const char* kHeldByAnother = "another program holds it";

/// Whether the port exists, may be read and written, is free, takes 230400 baud, and does not bring MAVLink poses.
CheckResult check_port(const std::string& path);
/// The latency timer of an FTDI adapter: by default it collects bytes for 16 ms, more than a tick; at most 2 is good.
CheckResult check_adapter(const std::string& path);
/// Whether the program may run with real-time priority and lock its memory.
CheckResult check_real_time();
/// The lateness of ticks of 10 ms; takes half a second.
CheckResult check_clock();
CheckResult check_governor();
/// @param folder where flight logs go.
CheckResult check_disk(const std::string& folder);

}  // namespace m100::companion::preflight
