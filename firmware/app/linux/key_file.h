// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fstream>
#include <string>

#include "firmware/app/linux/subcommands.h"
#include "protocol/cipher.h"

namespace m100::app {

/// The app's key: 64 hexadecimal digits, the first word of the file.
inline protocol::CipherKey read_key(const std::string& path) {
  std::ifstream file(path);
  if (!file) {
    throw UsageError(path + ": cannot be read");
  }
  std::string hex;
  file >> hex;
  protocol::CipherKey key{};
  if (hex.size() != 2 * key.size() || hex.find_first_not_of("0123456789abcdefABCDEF") != std::string::npos) {
    throw UsageError(path + ":1: the key needs 64 hexadecimal digits");
  }
  for (std::size_t i = 0; i < key.size(); ++i) {
    key[i] = static_cast<std::uint8_t>(std::stoul(hex.substr(2 * i, 2), nullptr, 16));
  }
  return key;
}

}  // namespace m100::app
