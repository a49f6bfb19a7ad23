// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <fstream>
#include <string>
#include <string_view>
#include <utility>

#include "firmware/companion/files/text/regular_file.h"
#include "host_tests/lab/input_error.h"

namespace m100::lab {

/// Throws unless `file` exists and is a regular file: a device or a pipe has no end. @throws InputError
inline void require_regular(const std::string& file) {
  if (const std::string why = companion::why_not_read(file); !why.empty()) {
    throw InputError(file, 0, "", why);
  }
}

/// All bytes of a regular file, see companion::read_regular(). @throws InputError
inline std::string whole_file(const std::string& file, std::uintmax_t most = companion::kMaxFileBytes) {
  companion::FileContent content = companion::read_regular(file, most);
  if (!content.why_not.empty()) {
    throw InputError(file, 0, "", content.why_not);
  }
  return std::move(content.bytes);
}

/// Writes a file. @param option  names it in the message. @throws InputError if it cannot be written completely.
inline void write_whole_file(const std::string& file, std::string_view bytes, const std::string& option = "") {
  std::ofstream out(file, std::ios::binary);
  out << bytes;
  if (!out.flush()) {
    throw InputError(file, 0, option, "cannot be written");
  }
}

}  // namespace m100::lab
