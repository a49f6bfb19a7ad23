// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

#include "host_tests/lab/input_error.h"

namespace m100::lab {

/// Throws unless `file` is a regular file that can be opened: a device or a pipe has no end, and no size that memory
/// and time could be held to. @throws InputError
inline void require_regular(const std::string& file) {
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (error || !std::filesystem::exists(status)) {
    throw InputError(file, 0, "", "cannot be opened");
  }
  if (!std::filesystem::is_regular_file(status)) {
    throw InputError(file, 0, "", "is no regular file: copy what it gives into one");
  }
}

/// All bytes of a regular file. @throws InputError: cannot be opened or read, no regular file, more than `most` bytes.
inline std::string whole_file(const std::string& file, std::uintmax_t most = std::uintmax_t{1} << 31U) {
  require_regular(file);
  std::ifstream in(file, std::ios::binary);
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  if (!in || error) {
    throw InputError(file, 0, "", "cannot be opened");
  }
  if (size > most) {
    throw InputError(file, 0, "", "is larger than " + std::to_string(most >> 20U) + " MiB");
  }
  std::string bytes(static_cast<std::size_t>(size), '\0');
  in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (in.bad()) {
    throw InputError(file, 0, "", "cannot be read");
  }
  bytes.resize(static_cast<std::size_t>(in.gcount()));
  return bytes;
}

/// Throws if `output` is the same file as `input`: nothing overwrites what it reads. @param option of the output.
inline void refuse_overwriting(const std::string& input, const std::string& output, const std::string& option) {
  std::error_code error;
  if (!output.empty() && !input.empty() && std::filesystem::equivalent(input, output, error) && !error) {
    throw InputError(output, 0, option, "is a file that is read here; it would be overwritten");
  }
}

/// Throws unless `output` can be written, before any work is done for it. An existing file keeps its content.
inline void require_writable(const std::string& output, const std::string& option) {
  if (output.empty()) {
    return;
  }
  std::error_code error;
  const bool was_there = std::filesystem::exists(output, error);
  const bool can = static_cast<bool>(std::ofstream(output, std::ios::app | std::ios::binary));
  if (!was_there) {
    std::filesystem::remove(output, error);
  }
  if (!can) {
    throw InputError(output, 0, option, "cannot be written");
  }
}

}  // namespace m100::lab
