// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "firmware/app/linux/subcommands.h"

namespace m100::app {

/// The whole file. Errors: UsageError that names it, also for a folder, which opens but cannot be read.
inline std::string read_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file || std::filesystem::is_directory(path)) {
    throw UsageError(path + ": cannot be read");
  }
  return std::string(std::istreambuf_iterator<char>(file), {});
}

/// Before something long begins: whether its result will have a place. Errors: UsageError.
inline void expect_writable(const std::string& path) {
  if (!path.empty() && !std::ofstream(path, std::ios::app)) {
    throw UsageError(path + ": cannot be written");
  }
}

}  // namespace m100::app
