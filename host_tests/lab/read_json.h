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

/// The brackets of a JSON text that are open, and the commas since each.
class OpenBrackets {
 public:
  /// Takes a letter outside of quotes. @returns false: nested or long beyond any of ours.
  bool take(char letter) {
    if (letter == '{' || letter == '[') {
      return open(letter == '{');
    }
    if (letter == '}' || letter == ']') {
      depth_ -= depth_ > 0 ? 1U : 0U;
    }
    return letter != ',' || depth_ == 0 || count_name();
  }

 private:
  bool open(bool is_object) {
    if (depth_ == kDeepestJson) {
      return false;
    }
    commas_[depth_++] = is_object ? 0 : kMostJsonNames;  // of an array they are not counted
    return true;
  }
  bool count_name() {
    std::size_t& commas = commas_[depth_ - 1];
    return commas == kMostJsonNames || ++commas < kMostJsonNames;
  }

  std::array<std::size_t, kDeepestJson> commas_{};
  std::size_t depth_ = 0;
};

/// @param quote where a text in quotes begins. @returns where it ends.
inline std::size_t end_of_quoted(std::string_view text, std::size_t quote) {
  std::size_t at = quote + 1;
  while (at < text.size() && text[at] != '"') {
    at += text[at] == '\\' ? 2U : 1U;
  }
  return at;
}

/// Whether a JSON text is worth reading: a library that copies what is nested goes as deep on the stack, and one that
/// keeps the order of the names of an object looks through all of them for each (150 000 take half a minute).
inline bool is_modest_json(std::string_view text) {
  OpenBrackets brackets;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '"') {
      i = end_of_quoted(text, i);
    } else if (!brackets.take(text[i])) {
      return false;
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
