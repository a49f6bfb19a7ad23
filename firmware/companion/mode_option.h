// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <CLI/CLI.hpp>

#include <string>

#include "firmware/companion/files/mode.h"

namespace m100::companion {

/// Adds the option --mode. present_mode_word() replaces the former mode's word.
inline void add_mode_option(CLI::App& command, std::string& mode, const std::string& description) {
  command.add_option("--mode", mode, description)
      ->transform([](const std::string& word) { return std::string(present_mode_word(word)); })
      ->check(CLI::IsMember(kModeNames));
}

}  // namespace m100::companion
