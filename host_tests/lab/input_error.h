// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stdexcept>
#include <string>

namespace m100::lab {

/// Bad input of any kind: one line that names file, line and key, printed to stderr; the program then exits with 2.
class InputError : public std::runtime_error {
 public:
  /// @param line 1-based; 0 where a line makes no sense. @param key the column, TOML key or option; may be empty.
  InputError(const std::string& file, long line, const std::string& key, const std::string& what)
      : std::runtime_error(file + (line > 0 ? ":" + std::to_string(line) : "") + ": " +
                           (key.empty() ? "" : "'" + key + "': ") + what) {}
};

}  // namespace m100::lab
