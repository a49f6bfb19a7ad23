// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <exception>
#include <string>
#include <vector>

#include "firmware/companion/command_line.h"
#include "host_tests/refusal.h"

namespace m100::lab {

/// Runs a subcommand as the program does. @returns the message with which it refuses; empty: it was done.
inline std::string refusal_of(void (*add)(companion::CommandLine&), std::vector<std::string> words) {
  companion::CommandLine lab{"test"};
  add(lab);
  return host_tests::refusal_by<std::exception>([&] { lab.parse(std::move(words)); });
}

}  // namespace m100::lab
