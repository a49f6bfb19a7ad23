// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/stat.h>

#include <algorithm>
#include <sstream>
#include <string>

#include "firmware/companion/files/text/regular_file.h"
#include "firmware/companion/subcommands.h"
#include "protocol/cipher.h"

namespace m100::companion {

/// Reads a key: 64 hexadecimal digits, and nothing else in the file. Anybody with the key can fly the aircraft, so a
/// file that others than its owner can read or change is refused. Errors: UsageError.
inline protocol::CipherKey read_key(const std::string& path) {
  constexpr std::uintmax_t kMaxKeyBytes = 1U << 20U;
  const FileContent content = read_regular(path, kMaxKeyBytes);
  if (!content.why_not.empty()) {
    throw UsageError(path + ": " + content.why_not);
  }
  struct stat status {};
  if (stat(path.c_str(), &status) != 0 || (status.st_mode & (S_IRWXG | S_IRWXO)) != 0) {
    throw UsageError(path + ": holds a key that others can read: chmod 600 " + path);
  }
  protocol::CipherKey key{};
  std::istringstream words(content.bytes);
  std::string hex, more;
  words >> hex >> more;
  if (hex.size() != 2 * key.size() || hex.find_first_not_of("0123456789abcdefABCDEF") != std::string::npos) {
    throw UsageError(path + ":1: the key needs 64 hexadecimal digits");
  }
  if (!more.empty()) {
    const auto end = content.bytes.begin() +
                     static_cast<std::ptrdiff_t>(content.bytes.find(more, content.bytes.find(hex) + hex.size()));
    throw UsageError(path + ":" + std::to_string(1 + std::count(content.bytes.begin(), end, '\n')) +
                     ": something follows the key: a file holds one key only");
  }
  for (std::size_t i = 0; i < key.size(); ++i) {
    key[i] = static_cast<std::uint8_t>(std::stoul(hex.substr(2 * i, 2), nullptr, 16));
  }
  return key;
}

}  // namespace m100::companion
