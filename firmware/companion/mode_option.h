// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "firmware/companion/command_line.h"
#include "firmware/companion/files/mode.h"

namespace m100::companion {

/// Adds the option --mode. present_mode_word() replaces the former mode's word.
inline void add_mode_option(const Subcommand& command, std::string& mode, const std::string& description) {
  command.add_option("--mode", mode, description)
      .replaced_by([](const std::string& word) { return std::string(present_mode_word(word)); })
      .one_of({kModeNames.begin(), kModeNames.end()});
}

}  // namespace m100::companion
