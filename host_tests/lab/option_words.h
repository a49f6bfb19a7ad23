// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdlib>
#include <sstream>
#include <string>
#include <vector>

#include "firmware/companion/files/mode.h"
#include "firmware/mpc/law.h"
#include "host_tests/lab/input_error.h"

namespace m100::lab {

/// "a,b,c" at every `between`.
inline std::vector<std::string> parts(const std::string& text, char between) {
  std::vector<std::string> out;
  std::stringstream stream(text);
  for (std::string part; std::getline(stream, part, between);) {
    out.push_back(part);
  }
  return out;
}

/// @throws InputError naming the option: not a finite number, or more than one.
inline double number(const std::string& option, const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != '\0' || !std::isfinite(value)) {
    throw InputError(option, 0, text, "not a number");
  }
  return value;
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
