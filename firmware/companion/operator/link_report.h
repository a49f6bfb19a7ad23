// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <ostream>
#include <string>
#include <string_view>

#include "firmware/companion/files/text/json.h"
#include "firmware/link/link_health.h"

namespace m100::companion {

/// The health of a link as one JSON object, in SI units.
Json to_json(const link::LinkHealth& health);
/// "link_health {...}": most numbers of to_json() in one line, for the flight log. No heap.
using HealthText = std::array<char, 1024>;
std::string_view health_line(const link::LinkHealth& health, HealthText& space);

/// The health of a link as a few lines for the operator.
void print(std::ostream& out, const link::LinkHealth& health);

/// Writes the result of a subcommand. Errors: UsageError naming the file and what is wrong.
void write_json(const std::string& path, const Json& result);
/// As write_json(), after a flight: an error goes to stderr and does not change the exit code. Empty path: nothing.
void write_result(const std::string& path, const Json& result);

}  // namespace m100::companion
