// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "firmware/companion/files/text/json.h"
#include "host_tests/lab/input_error.h"
#include "host_tests/lab/whole_file.h"

namespace m100::lab {

/// Writes the file of an option --json; does nothing if the option was not given. Errors: InputError if the file cannot
/// be written completely.
inline void write_json(const std::string& file, const Json& json, int indent = 1) {
  if (!file.empty()) {
    write_whole_file(file, json.dump(indent) + "\n", "--json");
  }
}

/// Calls `use`, which reads values from a file's JSON. @throws InputError: a value is missing or has the wrong type.
/// @param lacks the message's first words: why the file is not accepted.
template <typename Use>
auto of_json(const std::string& file, const char* lacks, const Use& use) {
  try {
    return use();
  } catch (const JsonError& wrong) {
    throw InputError(file, 0, "", lacks + std::string(": ") + wrong.what());
  }
}

}  // namespace m100::lab
