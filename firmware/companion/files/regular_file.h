// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

namespace m100::companion {

/// Why a file is not read to its end; empty: it may be. A device or a pipe has no end, and no size that memory and time
/// could be held to.
inline std::string why_not_read(const std::string& path) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (error || !std::filesystem::exists(status) || std::filesystem::is_directory(status)) {
    return "cannot be read";
  }
  return std::filesystem::is_regular_file(status) ? "" : "is no regular file: copy what it gives into one";
}

}  // namespace m100::companion
