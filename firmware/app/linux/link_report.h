// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <ostream>
#include <string>
#include <string_view>

#include "firmware/app/link_health.h"

namespace m100::app {

/// The health of a link as one JSON object, in SI units.
std::string to_json(const LinkHealth& health);
/// "link_health {...}": the same numbers in one line for the flight log. No heap.
using HealthText = std::array<char, 1024>;
std::string_view health_line(const LinkHealth& health, HealthText& space);

/// The same for people, a few lines.
void print(std::ostream& out, const LinkHealth& health);

/// A string as JSON has it, quotes included.
std::string quoted(std::string_view text);

/// Writes text to a file, or throws UsageError naming it.
void write_file(const std::string& path, const std::string& text);

}  // namespace m100::app
