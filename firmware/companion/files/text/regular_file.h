// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>

namespace m100::companion {

/// Largest size of a file that a person writes (vehicle, plant, flight, course, script, map); they have up to 20 kB.
inline constexpr std::uintmax_t kMaxTextBytes = std::uintmax_t{1} << 24U;
/// Largest size of a log or a table. On a 32-bit machine it leaves room for the program and for the parsed content.
inline constexpr std::uintmax_t kMaxFileBytes = std::uintmax_t{1} << (sizeof(std::size_t) > 4 ? 31U : 29U);
static_assert(kMaxFileBytes < std::uintmax_t{std::numeric_limits<std::size_t>::max() / 2}, "one string holds it");

/// Why a path is not read as a file; empty: it may be read. A device or a pipe has no end and no known size, so reading
/// it could take unlimited memory and time.
inline std::string why_not_read(const std::string& path) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (error || !std::filesystem::exists(status)) {
    return "cannot be read";
  }
  if (std::filesystem::is_directory(status)) {
    return "is a folder, not a regular file";
  }
  return std::filesystem::is_regular_file(status) ? "" : "is not a regular file: copy its content into one";
}

struct FileContent {
  std::string bytes;
  std::string why_not;  ///< empty: `bytes` is the whole file
};

/// Reads a regular file of at most `max_bytes` bytes into memory, or gives the reason why not. Both programs read
/// the operator's files through it, except those that m100-lab reads in pieces.
inline FileContent read_regular(const std::string& path, std::uintmax_t max_bytes = kMaxFileBytes) {
  if (std::string why = why_not_read(path); !why.empty()) {
    return {.bytes = "", .why_not = std::move(why)};
  }
  std::ifstream file(path, std::ios::binary);
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (!file || error) {
    return {.bytes = "", .why_not = "cannot be read"};
  }
  if (size > max_bytes) {
    return {.bytes = "", .why_not = "is larger than " + std::to_string(max_bytes >> 20U) + " MiB"};
  }
  FileContent out{.bytes = std::string(static_cast<std::size_t>(size), '\0'), .why_not = ""};
  file.read(out.bytes.data(), static_cast<std::streamsize>(out.bytes.size()));
  if (file.bad()) {
    return {.bytes = "", .why_not = "cannot be read"};
  }
  out.bytes.resize(static_cast<std::size_t>(file.gcount()));
  return out;
}

}  // namespace m100::companion
