// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <CLI/CLI.hpp>

#include <algorithm>
#include <exception>
#include <string>
#include <vector>

namespace m100::lab {

/// Runs a subcommand as the program does. @returns the message with which it refuses; empty: it was done.
inline std::string refusal_of(void (*add)(CLI::App&), std::vector<std::string> words) {
  CLI::App lab{"test"};
  add(lab);
  std::reverse(words.begin(), words.end());  // the order that CLI11 asks for
  try {
    lab.parse(words);
  } catch (const std::exception& wrong) {
    return wrong.what();
  }
  return "";
}

}  // namespace m100::lab
