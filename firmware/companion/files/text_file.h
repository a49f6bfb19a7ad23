// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>

#include "firmware/companion/files/regular_file.h"
#include "firmware/companion/subcommands.h"

namespace m100::companion {

/// The whole file. Errors: UsageError that names it, also for a folder, which opens but cannot be read, and for a
/// device.
inline std::string read_file(const std::string& path) {
  if (const std::string why = why_not_read(path); !why.empty()) {
    throw UsageError(path + ": " + why);
  }
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    throw UsageError(path + ": cannot be read");
  }
  return std::string(std::istreambuf_iterator<char>(file), {});
}

/// Why a file cannot be written, in words that say what to do; else the system's own. @param error as errno has it.
inline std::string why_not_written(int error) {
  switch (error) {
    case ENOSPC:
      return "the disk is full";
    case EDQUOT:
      return "the disk quota is used up";
    case EFBIG:
      return "the file size limit is reached (ulimit -f)";
    case EROFS:
      return "the file system is read-only";
    default:
      return std::strerror(error);
  }
}

/// Before something long begins: whether its result will have a place. Errors: UsageError.
inline void expect_writable(const std::string& path) {
  errno = 0;
  if (!path.empty() && !std::ofstream(path, std::ios::app)) {
    throw UsageError(path + ": cannot be written: " + why_not_written(errno));
  }
}

/// The whole file, anew. Errors: UsageError that names it and what is wrong.
inline void write_file(const std::string& path, const std::string& text) {
  errno = 0;
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file << text << std::flush;
  if (!file) {
    throw UsageError(path + ": cannot be written: " + why_not_written(errno));
  }
}

}  // namespace m100::companion
