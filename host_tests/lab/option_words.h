// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdlib>
#include <string>
#include <vector>

#include "firmware/companion/files/mode.h"
#include "firmware/companion/files/plain_number.h"
#include "firmware/mpc/law.h"
#include "host_tests/lab/input_error.h"

namespace m100::lab {

/// "a,b,c" at every `between`: one part more than there are of these, so that "a," has an empty one at its end.
inline std::vector<std::string> parts(const std::string& text, char between) {
  std::vector<std::string> out(1);
  for (const char letter : text) {
    if (letter == between) {
      out.emplace_back();
    } else {
      out.back() += letter;
    }
  }
  return out;
}

/// The words of an option's list, with commas between. @throws InputError naming the option: one of them is empty,
/// where a word was forgotten, or a shell knew no such variable.
inline std::vector<std::string> list_of(const std::string& option, const std::string& text) {
  std::vector<std::string> out = parts(text, ',');
  if (std::find(out.begin(), out.end(), "") != out.end()) {
    throw InputError(option, 0, text, "has an empty word in its list");
  }
  return out;
}

/// @throws InputError naming the option: not a finite number, or more than one.
inline double number(const std::string& option, const std::string& text) {
  if (!companion::is_plain_number(text)) {
    throw InputError(option, 0, text.empty() ? "''" : text, "not a number");
  }
  return std::strtod(text.c_str(), nullptr);
}

/// What --law says. @throws InputError where it is no law.
inline mpc::Law law_of(const std::string& word) {
  const std::optional<mpc::Law> law = mpc::law_of(word);
  if (!law) {
    throw InputError("--law", 0, word, "is no law: mpc and lqr are");
  }
  return *law;
}

/// What --mode says. @throws InputError where it is no mode.
inline companion::Mode mode_of(const std::string& word) {
  const std::optional<companion::Mode> mode = companion::mode_named(word);
  if (!mode) {
    throw InputError("--mode", 0, word, "is no mode: field and calm_room are");
  }
  return *mode;
}

}  // namespace m100::lab
