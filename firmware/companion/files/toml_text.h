// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

// toml++ 3.3 ends a debug build where a text is none that its author thought of ("[", then a new line); what follows
// its checks refuses such a text as well.
#define TOML_ASSERT(condition) static_cast<void>(0)
#include <toml++/toml.h>

namespace m100::companion {

/// A text that is not TOML. Whoever reads the file puts its name and `line` before what() in an error of its own kind.
struct TomlTextError : std::runtime_error {
  TomlTextError(long at_line, const std::string& what) : std::runtime_error(what), line(at_line) {}
  long line = 0;  ///< 1-based
};

/// The same TOML in ASCII: what is not ASCII is an escape in a string, where it may stand, and a question mark in a
/// comment. Lines stay where they were. Errors: TomlTextError at the first such character anywhere else, at one that is
/// not UTF-8, and in a literal string of several lines, which knows no escapes.
std::string ascii_toml(std::string_view text);

/// The table that a text of TOML 1.0 holds. Errors: TomlTextError. Every TOML file of ours is read through this,
/// because toml++ 3.3 runs into undefined behaviour where a letter that is not ASCII stands outside quotes. Only this
/// header may include toml++.
toml::table parse_toml(std::string_view text);

}  // namespace m100::companion
