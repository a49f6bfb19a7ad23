// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cerrno>
#include <cstring>
#include <fstream>
#include <string>
#include <utility>

#include "firmware/companion/files/text/regular_file.h"
#include "firmware/companion/subcommands.h"

namespace m100::companion {

/// The whole file, see read_regular(). Errors: UsageError that names it.
inline std::string read_file(const std::string& path, std::uintmax_t max_bytes = kMaxTextBytes) {
  FileContent content = read_regular(path, max_bytes);
  if (!content.why_not.empty()) {
    throw UsageError(path + ": " + content.why_not);
  }
  return std::move(content.bytes);
}

/// Why a file cannot be written, for the frequent causes in our words, otherwise in the system's. @param error errno.
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

/// Writes the whole file, replacing an old one. Errors: UsageError that names it and what is wrong.
inline void write_file(const std::string& path, const std::string& text) {
  errno = 0;
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file << text << std::flush;
  if (!file) {
    throw UsageError(path + ": cannot be written: " + why_not_written(errno));
  }
}

}  // namespace m100::companion
