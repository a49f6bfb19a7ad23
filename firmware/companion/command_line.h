// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fcntl.h>
#include <unistd.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstdio>
#include <iostream>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/companion/files/text/plain_number.h"
#include "firmware/companion/files/text/printable.h"
#include "firmware/companion/files/text/suggestion.h"
#include "firmware/companion/subcommands.h"

namespace m100::companion {

// What the main functions of both programs do with their subcommands.

/// Opens /dev/null for each standard stream that is closed. Otherwise the next file to be opened would take its number,
/// and printed text would go to the autopilot's port or into a result.
inline void fill_standard_streams() {
  int descriptor = open("/dev/null", O_RDWR);
  while (descriptor >= 0 && descriptor <= STDERR_FILENO) {
    descriptor = open("/dev/null", O_RDWR);
  }
  if (descriptor >= 0) {
    close(descriptor);
  }
}

/// Whether all text for standard output was written; on a full disk it is lost.
inline bool all_output_written() {
  std::cout.flush();
  return std::cout && std::fflush(stdout) == 0 && std::ferror(stdout) == 0;
}

/// The text without anything that may be a key (a run of exactly 64 hexadecimal digits): a key given on the command
/// line must not appear in a journal.
inline std::string without_keys(std::string text) {
  constexpr std::size_t kDigits = 64;
  constexpr const char* kHexadecimal = "0123456789abcdefABCDEF";
  for (std::size_t at = text.find_first_of(kHexadecimal); at != std::string::npos;
       at = text.find_first_of(kHexadecimal, at)) {
    const std::size_t end = std::min(text.find_first_not_of(kHexadecimal, at), text.size());
    if (end - at == kDigits) {
      text.replace(at, kDigits, "(64 digits: a key belongs in a file, not on a command line)");
    }
    at = end - at == kDigits ? at + 1 : end;
  }
  return text;
}

struct Example {
  std::string_view command;  ///< the words of the subcommand: "fly", "mpc solve"
  std::string_view line;     ///< a whole command line that does something useful
};

/// Ends each subcommand's --help with an example. A test checks that each subcommand has one.
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

/// Makes every option refuse an empty value: `--course "$COURSE"` without a COURSE in the shell would hover instead,
/// and an empty `--key-file` would fly unencrypted. Call it when all subcommands have their options.
inline void refuse_empty_words(CLI::App& app) {
  for (CLI::Option* const option : app.get_options()) {
    option->check([](const std::string& word) { return std::string(word.empty() ? "is given, but empty" : ""); }, "");
  }
  for (CLI::App* const command : app.get_subcommands({})) {
    refuse_empty_words(*command);
  }
}

/// What is wrong with the value of an option that takes a number; empty: nothing.
inline std::string odd_number(const std::string& word, bool whole) {
  const bool is_plain = whole ? is_plain_whole_number(word) : is_plain_number(word);
  return is_plain ? std::string() : "'" + word + "' is not a " + (whole ? "whole number" : "decimal number");
}

/// Makes options accept only decimal, finite numbers. Call it when all subcommands have their options.
inline void refuse_odd_numbers(CLI::App& app) {
  for (CLI::Option* const option : app.get_options()) {
    const std::string type = option->get_type_name();
    const bool whole = type.starts_with("INT") || type.starts_with("UINT");
    if (whole || type.starts_with("FLOAT")) {
      option->check([whole](const std::string& word) { return odd_number(word, whole); }, "");
    }
  }
  for (CLI::App* const command : app.get_subcommands({})) {
    refuse_odd_numbers(*command);
  }
}

/// The message if `command` has no such option; empty if it has it.
inline std::string unknown_option(const CLI::App& command, const std::string& word) {
  const std::string name = word.substr(0, word.find('='));
  if (command.get_option_no_throw(name) != nullptr) {
    return "";
  }
  std::vector<std::string> known;
  for (const CLI::Option* const option : command.get_options()) {
    known.push_back("--" + (option->get_lnames().empty() ? "" : option->get_lnames().front()));
  }
  return word + ": no such option" + did_you_mean(name, known);
}

/// The message about the first unknown word of a command line: an option that its subcommand does not have, or a word
/// where a subcommand must be. Empty: there is none. CLI11 would report a missing option first, which may be the same
/// option, misspelt.
inline std::string unknown_word(const CLI::App& app, std::span<char* const> words) {
  const CLI::App* at = &app;
  for (const std::string word : words) {
    const std::vector<const CLI::App*> commands = at->get_subcommands([](const CLI::App* /*any*/) { return true; });
    const auto named = std::find_if(commands.begin(), commands.end(),
                                    [&](const CLI::App* command) { return command->get_name() == word; });
    if (named != commands.end()) {
      at = *named;
    } else if (word.starts_with("--") && word.size() > 2) {
      if (std::string wrong = unknown_option(*at, word); !wrong.empty()) {
        return wrong;
      }
    } else if (!commands.empty() && !word.starts_with('-')) {
      return "no subcommand '" + printable(word, 60) + "'" + did_you_mean(word, commands, &CLI::App::get_name);
    }
  }
  return "";
}

/// What to append to CLI11's message about a word that is not in its list, "--mode: feild not in {field,robust}":
/// the word of the list that may be meant. Empty for every other message.
inline std::string listed_word_meant(const std::string& message) {
  constexpr std::string_view kIn = " not in {";
  const std::size_t at = message.find(kIn);
  const std::size_t begin = at == std::string::npos ? at : message.rfind(' ', at - 1);
  if (begin == std::string::npos || !message.ends_with('}')) {
    return "";
  }
  std::vector<std::string> listed(1);
  for (const char letter : message.substr(at + kIn.size(), message.size() - 1 - at - kIn.size())) {
    letter == ',' ? listed.emplace_back() : listed.back() += std::string(1, letter);
  }
  return did_you_mean(message.substr(begin + 1, at - begin - 1), listed);
}

/// The one-line message for a command line that CLI11 does not parse; empty if it asks for help or the version and has
/// no unknown word.
inline std::string refusal(const CLI::App& app, std::span<char* const> words, const CLI::ParseError& wrong) {
  if (const std::string unknown = unknown_word(app, words); !unknown.empty()) {
    const bool has_key =
        std::any_of(words.begin(), words.end(), [](const char* word) { return without_keys(word) != word; });
    return unknown + (has_key ? "; a key belongs in a file, not on a command line" : "; see --help");
  }
  if (dynamic_cast<const CLI::Success*>(&wrong) != nullptr) {
    return "";
  }
  const bool is_missing = dynamic_cast<const CLI::RequiredError*>(&wrong) != nullptr;
  return wrong.what() + listed_word_meant(wrong.what()) + (is_missing ? "; see --help" : "");
}

/// Runs the subcommand that the command line names. @param flights subcommands whose exit code does not depend on
/// whether the output could be written. @returns the program's exit code; bad input is a line on stderr.
inline int run_subcommand(CLI::App& app, const std::string& program, std::span<const Example> examples,
                          std::span<char*> words, std::span<const std::string_view> flights = {}) {
  add_examples(app, examples);
  refuse_empty_words(app);
  refuse_odd_numbers(app);
  const auto refuse = [&program](const std::string& why) {
    std::cerr << program << ": " << printable(without_keys(why)) << "\n";
    return kBadInput;
  };
  try {
    app.parse(static_cast<int>(words.size()), words.data());
  } catch (const CLI::RuntimeError& stop) {
    return stop.get_exit_code();
  } catch (const CLI::ParseError& wrong) {
    const std::string why = refusal(app, words.subspan(1), wrong);
    return why.empty() ? app.exit(wrong) : refuse(why);
  } catch (const std::exception& wrong) {
    return refuse(wrong.what());
  }
  const bool flew = std::ranges::count(flights, app.get_subcommands().front()->get_name()) > 0;
  return flew || all_output_written() ? kDone : refuse("standard output: cannot be written");
}

}  // namespace m100::companion
