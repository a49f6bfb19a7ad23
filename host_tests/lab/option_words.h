// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdlib>
#include <string>
#include <vector>

#include "firmware/companion/files/mode.h"
#include "firmware/companion/files/text/plain_number.h"
#include "firmware/companion/files/text/suggestion.h"
#include "firmware/mpc/law.h"
#include "host_tests/lab/input_error.h"

namespace m100::lab {

/// Splits a text at every `between`. There is one part more than there are separators: "a," ends with an empty one.
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

/// The words of an option's comma-separated list. @throws InputError naming the option: one of the words is empty,
/// because it was forgotten or a shell variable is not set.
inline std::vector<std::string> list_of(const std::string& option, const std::string& text) {
  std::vector<std::string> out = parts(text, ',');
  if (std::find(out.begin(), out.end(), "") != out.end()) {
    throw InputError(option, 0, text, "has an empty word in its list");
  }
  return out;
}

/// The number that an option gives. @throws InputError naming the option: the text is not exactly one finite number.
inline double number(const std::string& option, const std::string& text) {
  if (!companion::is_plain_number(text)) {
    throw InputError(option, 0, text.empty() ? "''" : text, "not a number");
  }
  return std::strtod(text.c_str(), nullptr);
}

/// The word of --law for experiments::in_paper_configuration().
inline constexpr const char* kPaperLaw = "paper";

/// The horizontal law that --law names; "paper" names the MPC. @throws InputError: there is no such law.
inline mpc::Law law_of(const std::string& word) {
  const std::optional<mpc::Law> law = mpc::law_of(word == kPaperLaw ? "mpc" : word);
  if (!law) {
    throw InputError("--law", 0, word,
                     "is not a law; the laws are mpc, lqr and paper" +
                         companion::did_you_mean(word, std::array<std::string_view, 3>{"mpc", "lqr", kPaperLaw}));
  }
  return *law;
}

/// The mode that --mode names. @throws InputError: there is no such mode.
inline companion::Mode mode_of(const std::string& word) {
  const std::optional<companion::Mode> mode = companion::mode_named(word);
  if (!mode) {
    throw InputError(
        "--mode", 0, word,
        "is not a mode; the modes are field and robust" +
            companion::did_you_mean(word, companion::kModes, [](companion::Mode one) { return name(one); }));
  }
  return *mode;
}

}  // namespace m100::lab
