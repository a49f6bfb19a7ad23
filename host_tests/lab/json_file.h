// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "host_tests/lab/input_error.h"

namespace m100::lab {

/// A JSON value as text. Bytes that are not UTF-8 (the bytes of a path may be anything) become the replacement
/// character, so that an unprintable name does not lose the results.
template <typename Json>
std::string json_text(const Json& json, int indent = -1) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

/// Writes the file of an option --json; does nothing if the option was not given. Errors: InputError if the file cannot
/// be written completely.
template <typename Json>
void write_json(const std::string& file, const Json& json, int indent = 1) {
  if (file.empty()) {
    return;
  }
  std::ofstream out(file);
  out << json_text(json, indent) << "\n";
  if (!out.flush()) {
    throw InputError(file, 0, "--json", "cannot be written");
  }
}

}  // namespace m100::lab
