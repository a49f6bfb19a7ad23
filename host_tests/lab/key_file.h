// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "firmware/companion/files/text/key_file.h"
#include "host_tests/lab/input_error.h"

namespace m100::lab {

/// Reads the app's key as `m100` does; the file must be readable by its owner only. @throws InputError
inline protocol::CipherKey read_key(const std::string& path) {
  protocol::CipherKey key{};
  if (const companion::KeyFileProblem problem = companion::load_key(path, key); !problem.what.empty()) {
    throw InputError(path, problem.line, "", problem.what);
  }
  return key;
}

}  // namespace m100::lab
