// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "firmware/companion/doctor/check.h"

namespace m100::companion::doctor {

/// What the board itself may lack for a flight. Each looks once, changes nothing, and names the remedy.
Check check_port(const std::string& path);
/// FTDI adapters collect bytes for 16 ms unless told otherwise: more than one control period.
Check check_adapter(const std::string& path);
/// Whether the program may go before others, and keep its memory from being swapped out.
Check check_real_time();
/// How late ticks of 10 ms are; takes half a second.
Check check_clock();
Check check_governor();
/// @param folder where flight logs go.
Check check_disk(const std::string& folder);

}  // namespace m100::companion::doctor
