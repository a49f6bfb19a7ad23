// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "host_tests/lab/input_error.h"
#include "host_tests/lab/whole_file.h"

namespace m100::lab {

/// Ours are nested eight times at the most and have some hundred names.
inline constexpr std::size_t kDeepestJson = 64;
inline constexpr std::size_t kMostJsonNames = 10000;

/// Whether a JSON text is worth reading: a library that copies what is nested goes as deep on the stack, and one that
/// keeps the order of the names of an object looks through all of them for each (150 000 take half a minute).
inline bool is_modest_json(std::string_view text) {
  std::array<std::size_t, kDeepestJson> commas{};  // since each bracket that is open
  std::size_t depth = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char letter = text[i];
    if (letter == '"') {
      for (++i; i < text.size() && text[i] != '"'; ++i) {
        i += text[i] == '\\' ? 1U : 0U;
      }
    } else if (letter == '{' || letter == '[') {
      if (depth == kDeepestJson) {
        return false;
      }
      commas[depth++] = letter == '{' ? 0 : kMostJsonNames;
    } else if (letter == '}' || letter == ']') {
      depth -= depth > 0 ? 1U : 0U;
    } else if (letter == ',' && depth > 0 && commas[depth - 1] < kMostJsonNames &&
               ++commas[depth - 1] == kMostJsonNames) {
      return false;  // of an array they are not counted
    }
  }
  return true;
}

/// @returns a discarded value where the text is no JSON, or nested or long beyond any of ours.
template <typename Json = nlohmann::json>
Json parse_json(std::string_view text) {
  return is_modest_json(text) ? Json::parse(text, nullptr, false) : Json(Json::value_t::discarded);
}

/// Does what asks for values in a file's JSON. @throws InputError: one of them is missing or of another kind. @param
/// lacks what the file is not.
template <typename Use>
auto of_json(const std::string& file, const char* lacks, const Use& use) {
  try {
    return use();
  } catch (const nlohmann::json::exception& wrong) {
    const std::string why = wrong.what();
    throw InputError(file, 0, "", lacks + std::string(":") + why.substr(why.find(']') + 1));
  }
}

}  // namespace m100::lab
