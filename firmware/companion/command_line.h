// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <CLI/CLI.hpp>

#include <span>
#include <string>
#include <string_view>

namespace m100::companion {

// What the main functions of both programs do with their subcommands.

struct Example {
  std::string_view command;  ///< the words of the subcommand: "fly", "mpc solve"
  std::string_view line;     ///< a whole command line that does something useful
};

/// Ends each subcommand's --help with an example. Whether each has one is held by a test that walks them all.
inline void add_examples(CLI::App& app, std::span<const Example> examples, const std::string& words = "") {
  for (CLI::App* const command : app.get_subcommands({})) {
    const std::string name = words + (words.empty() ? "" : " ") + command->get_name();
    for (const Example& example : examples) {
      if (example.command == name) {
        const std::string before = command->get_footer();
        command->footer(before + (before.empty() ? "" : "\n\n") + "Example: " + std::string(example.line));
      }
    }
    add_examples(*command, examples, name);
  }
}

/// The first word of a command line that looks like an option and is none of its subcommand's; empty: there is none.
/// CLI11 complains about an option that is missing before one that it does not know, which may be the same, misspelt.
inline std::string unknown_option(const CLI::App& app, std::span<char* const> words) {
  const CLI::App* at = &app;
  for (const std::string word : words) {
    const std::vector<const CLI::App*> named =
        at->get_subcommands([&](const CLI::App* command) { return command->get_name() == word; });
    if (!named.empty()) {
      at = named.front();
    } else if (word.starts_with("--") && word.size() > 2 &&
               at->get_option_no_throw(word.substr(0, word.find('='))) == nullptr) {
      return word;
    }
  }
  return "";
}

/// What is said where something is missing on a command line.
inline std::string what_lacks(const CLI::App& app, std::span<char* const> words, const CLI::RequiredError& wrong) {
  const std::string unknown = unknown_option(app, words);
  return (unknown.empty() ? wrong.what() : unknown + ": no such option") + "; see --help";
}

}  // namespace m100::companion
