// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ostream>
#include <string>

#include "firmware/app/link_health.h"

namespace m100::app {

/// The health of a link as one JSON object, in SI units.
std::string to_json(const LinkHealth& health);

/// The same for people, a few lines.
void print(std::ostream& out, const LinkHealth& health);

/// A string as JSON has it, quotes included.
std::string quoted(std::string_view text);

/// Writes text to a file, or throws UsageError naming it.
void write_file(const std::string& path, const std::string& text);

}  // namespace m100::app
