// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

// toml++ 3.3 has assertions that end a debug build on some invalid texts ("[", then a new line); the code after them
// refuses such texts as well.
#define TOML_ASSERT(condition) static_cast<void>(0)
#include <toml++/toml.h>

namespace m100::companion {

/// A text that is not TOML. The reader of the file puts its name and `line` before what() in its own type of error.
struct TomlTextError : std::runtime_error {
  TomlTextError(long at_line, const std::string& what) : std::runtime_error(what), line(at_line) {}
  long line = 0;  ///< 1-based
};

/// Converts TOML to ASCII: a character that is not ASCII becomes an escape in a string and a question mark in a
/// comment. Line numbers stay the same. Errors: TomlTextError at the first such character anywhere else, also in a
/// literal string of several lines, which has no escapes; at bytes that are not UTF-8; at a name of too many parts.
std::string ascii_toml(std::string_view text);

/// Parses a text of TOML 1.0. Errors: TomlTextError. Every TOML file of ours is read through this function, because
/// toml++ 3.3 has undefined behaviour on a non-ASCII letter outside quotes. Only this header may include toml++.
toml::table parse_toml(std::string_view text);

}  // namespace m100::companion
