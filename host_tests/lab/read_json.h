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

/// Limits of a JSON text: nesting depth, and names in one object. Our own files have at most 8 and a few hundred.
inline constexpr std::size_t kDeepestJson = 64;
inline constexpr std::size_t kMaxJsonNames = 10000;

/// The open brackets of a JSON text, and for each open object the number of commas between its members so far.
class OpenBrackets {
 public:
  /// Takes a character outside quotes. @returns false: too deep nesting, or too many names in an object.
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
    commas_[depth_++] = is_object ? 0 : kMaxJsonNames;  // the commas of an array are not counted
    return true;
  }
  bool count_name() {
    std::size_t& commas = commas_[depth_ - 1];
    return commas == kMaxJsonNames || ++commas < kMaxJsonNames;
  }

  std::array<std::size_t, kDeepestJson> commas_{};
  std::size_t depth_ = 0;
};

/// @param quote index of the opening quote. @returns the index of the closing one; text.size() or more: there is none
inline std::size_t end_of_quoted(std::string_view text, std::size_t quote) {
  std::size_t at = quote + 1;
  while (at < text.size() && text[at] != '"') {
    at += text[at] == '\\' ? 2U : 1U;
  }
  return at;
}

/// Whether a JSON text keeps kDeepestJson and kMaxJsonNames. Deep values would overflow the stack when they are copied,
/// and an ordered object compares each new name with all earlier ones.
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

/// @returns a discarded value if the text is not JSON, is nested too deeply, or an object has too many names.
template <typename Json = nlohmann::json>
Json parse_json(std::string_view text) {
  return is_modest_json(text) ? Json::parse(text, nullptr, false) : Json(Json::value_t::discarded);
}

/// Calls `use`, which reads values from a file's JSON. @throws InputError: a value is missing or has the wrong type.
/// @param lacks the message's first words: why the file is not accepted.
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
