// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stdexcept>
#include <string>

namespace m100::companion {

/// An error in a file, in one line: "v.toml:12: 'axis.roll.damping_ratio': 9 is outside [0.05, 5]".
class FileError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
  /// @param line 1-based; 0 where a line makes no sense. @param key the column, TOML key or option; may be empty.
  FileError(const std::string& file, long line, const std::string& key, const std::string& what)
      : std::runtime_error(file + (line > 0 ? ":" + std::to_string(line) : "") + ": " +
                           (key.empty() ? "" : "'" + key + "': ") + what) {}
};

}  // namespace m100::companion
