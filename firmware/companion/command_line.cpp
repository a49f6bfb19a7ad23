// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/command_line.h"

#include <fcntl.h>
#include <unistd.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <sstream>

#include "firmware/companion/files/text/plain_number.h"
#include "firmware/companion/files/text/printable.h"
#include "firmware/companion/files/text/suggestion.h"

namespace m100::companion {
namespace {

/// Opens /dev/null for each standard stream that is closed. Otherwise the next file to be opened would take its number,
/// and printed text would go to the autopilot's port or into a result.
void fill_standard_streams() {
  int descriptor = open("/dev/null", O_RDWR);
  while (descriptor >= 0 && descriptor <= STDERR_FILENO) {
    descriptor = open("/dev/null", O_RDWR);
  }
  if (descriptor >= 0) {
    close(descriptor);
  }
}

/// Whether all text for standard output was written; on a full disk it is lost.
bool all_output_written() {
  std::cout.flush();
  return std::cout && std::fflush(stdout) == 0 && std::ferror(stdout) == 0;
}

/// The text without anything that may be a key (a run of exactly 64 hexadecimal digits): a key given on the command
/// line must not appear in a journal.
std::string without_keys(std::string text) {
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

/// Ends each subcommand's --help with an example. A test checks that each subcommand has one.
void add_examples(CLI::App& app, std::span<const Example> examples, const std::string& words = "") {
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
/// and an empty `--key-file` would fly unencrypted. One that takes a number takes only a decimal, finite one.
void refuse_odd_words(CLI::App& app) {
  for (CLI::Option* const option : app.get_options()) {
    option->check([](const std::string& word) { return std::string(word.empty() ? "is given, but empty" : ""); }, "");
    const std::string type = option->get_type_name();
    const bool whole = type.starts_with("INT") || type.starts_with("UINT");
    if (whole || type.starts_with("FLOAT")) {
      const auto wrong = [whole](const std::string& word) {
        const bool is_plain = whole ? is_plain_whole_number(word) : is_plain_number(word);
        return is_plain ? std::string() : "'" + word + "' is not a " + (whole ? "whole number" : "decimal number");
      };
      option->check(wrong, "");
    }
  }
  for (CLI::App* const command : app.get_subcommands({})) {
    refuse_odd_words(*command);
  }
}

/// The message if `command` has no such option; empty if it has it.
std::string unknown_option(const CLI::App& command, const std::string& word) {
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
std::string unknown_word(const CLI::App& app, std::span<char* const> words) {
  const CLI::App* at = &app;
  for (const std::string word : words) {
    const std::vector<const CLI::App*> commands = at->get_subcommands([](const CLI::App* /*any*/) { return true; });
    const auto named = std::ranges::find(commands, word, &CLI::App::get_name);
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

/// Makes an option refuse what is not in the list, and name the word of the list that may be meant.
template <typename Value>
CLI::Option* accept_only(CLI::Option* option, const std::vector<Value>& listed) {
  const CLI::IsMember list(listed);
  const auto wrong = [list, listed](const std::string& word) {
    const std::string message = list(word);
    std::vector<std::string> known(listed.size());
    std::ranges::transform(listed, known.begin(), [](const Value& one) { return CLI::detail::to_string(one); });
    return message + (message.empty() ? "" : did_you_mean(word, known));
  };
  return option->check(wrong, list.get_description());
}

/// The one-line message for a command line that CLI11 does not parse; empty if it asks for help or the version and has
/// no unknown word.
std::string refusal(const CLI::App& app, std::span<char* const> words, const CLI::ParseError& wrong) {
  if (const std::string unknown = unknown_word(app, words); !unknown.empty()) {
    const bool has_key = std::ranges::any_of(words, [](const char* word) { return without_keys(word) != word; });
    return unknown + (has_key ? "; a key belongs in a file, not on a command line" : "; see --help");
  }
  if (dynamic_cast<const CLI::Success*>(&wrong) != nullptr) {
    return "";
  }
  const bool is_missing = dynamic_cast<const CLI::RequiredError*>(&wrong) != nullptr;
  return std::string(wrong.what()) + (is_missing ? "; see --help" : "");
}

}  // namespace

Option Option::required() const { return Option(option_->required()); }
Option Option::needs(const std::string& other) const { return Option(option_->needs(other)); }
Option Option::excludes(const std::string& other) const { return Option(option_->excludes(other)); }
Option Option::one_of(const std::vector<std::string>& words) const { return Option(accept_only(option_, words)); }
Option Option::one_of(std::initializer_list<int> numbers) const { return Option(accept_only<int>(option_, numbers)); }
Option Option::in_range(double low, double high) const { return Option(option_->check(CLI::Range(low, high))); }
Option Option::in_range(int low, int high) const { return Option(option_->check(CLI::Range(low, high))); }

Option Option::from_to(double low, double high) const {
  std::ostringstream range;
  range << "from " << low << " to " << high;
  return check(
      [low, high, words = range.str()](const std::string& text) {
        char* end = nullptr;
        const double value = std::strtod(text.c_str(), &end);
        const bool is_inside = !text.empty() && *end == '\0' && value >= low && value <= high;
        return is_inside ? std::string() : "'" + text + "' is not a number " + words;
      },
      range.str());
}

Option Option::positive() const { return Option(option_->check(CLI::PositiveNumber)); }

Option Option::whole_number() const {
  return check(
      [](const std::string& text) {
        const bool is_whole = !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
        return is_whole ? std::string() : "'" + text + "' is not a whole number (0 or more)";
      },
      "a whole number");
}

Option Option::existing_file() const { return Option(option_->check(CLI::ExistingFile)); }
Option Option::existing_folder() const { return Option(option_->check(CLI::ExistingDirectory)); }
Option Option::check(const std::function<std::string(const std::string&)>& wrong,
                     const std::string& description) const {
  return Option(option_->check(wrong, description));
}
Option Option::replaced_by(const std::function<std::string(const std::string&)>& present) const {
  return Option(option_->transform(present));
}
Option Option::takes(int words) const { return Option(option_->expected(words)); }
Option Option::takes_one_each() const {
  return Option(option_->expected(1)->multi_option_policy(CLI::MultiOptionPolicy::TakeAll));
}
Option Option::takes_commas() const { return Option(option_->delimiter(',')); }
Option Option::type_name(const std::string& name) const { return Option(option_->type_name(name)); }

Subcommand Subcommand::add_subcommand(const std::string& name, const std::string& description) const {
  return Subcommand(app_->add_subcommand(name, description));
}
void Subcommand::require_subcommand() const { app_->require_subcommand(1); }
void Subcommand::footer(const std::string& text) const { app_->footer(text); }
void Subcommand::callback(const std::function<void()>& run) const { app_->callback(run); }

template <typename Value>
Option Subcommand::add_option(const std::string& names, Value& value, const std::string& description) const {
  return Option(app_->add_option(names, value, description));
}
template Option Subcommand::add_option(const std::string&, std::string&, const std::string&) const;
template Option Subcommand::add_option(const std::string&, double&, const std::string&) const;
template Option Subcommand::add_option(const std::string&, int&, const std::string&) const;
template Option Subcommand::add_option(const std::string&, std::uint32_t&, const std::string&) const;
template Option Subcommand::add_option(const std::string&, std::uint64_t&, const std::string&) const;
template Option Subcommand::add_option(const std::string&, std::vector<std::string>&, const std::string&) const;
template Option Subcommand::add_option(const std::string&, std::vector<double>&, const std::string&) const;

Option Subcommand::add_flag(const std::string& name, bool& value, const std::string& description) const {
  return Option(app_->add_flag(name, value, description));
}

void Subcommand::add_former_flag(const std::string& name, const std::string& why) const {
  app_->add_flag_callback(name, [name, why] { throw CLI::ValidationError(name, why); })->group("");
}

void Subcommand::exclude_others(const std::string& name) const {
  CLI::Option* const one = app_->get_option(name);
  const auto is_other = [&](const CLI::Option* option) { return option != one && option != app_->get_help_ptr(); };
  for (CLI::Option* const other : app_->get_options(is_other)) {
    one->excludes(other);
  }
}

bool Subcommand::is_given(const std::string& name) const { return app_->count(name) > 0; }

CommandLine::CommandLine(const std::string& description)
    : Subcommand(std::make_unique<CLI::App>(description).release()), owned_(app_) {}
CommandLine::~CommandLine() = default;

void CommandLine::show_defaults() { owned_->option_defaults()->always_capture_default(); }
void CommandLine::set_version(const std::string& text) { owned_->set_version_flag("--version", text); }

int CommandLine::run(const std::string& program, std::span<const Example> examples, std::span<char*> words,
                     std::span<const std::string_view> flights) {
  fill_standard_streams();
  add_examples(*owned_, examples);
  refuse_odd_words(*owned_);
  const auto refuse = [&program](const std::string& why) {
    std::cerr << program << ": " << printable(without_keys(why)) << "\n";
    return kBadInput;
  };
  try {
    owned_->parse(static_cast<int>(words.size()), words.data());
  } catch (const AnswerIsNo&) {
    return kAnswerIsNo;
  } catch (const CLI::ParseError& wrong) {
    const std::string why = refusal(*owned_, words.subspan(1), wrong);
    return why.empty() ? owned_->exit(wrong) : refuse(why);
  } catch (const std::exception& wrong) {
    return refuse(wrong.what());
  }
  const bool flew = std::ranges::count(flights, owned_->get_subcommands().front()->get_name()) > 0;
  return flew || all_output_written() ? kDone : refuse("standard output: cannot be written");
}

void CommandLine::read(int count, char** words) {
  try {
    owned_->parse(count, words);
  } catch (const CLI::ParseError& wrong) {
    std::exit(owned_->exit(wrong));
  }
}

void CommandLine::parse(std::vector<std::string> words) {
  std::reverse(words.begin(), words.end());  // the order that CLI11 asks for
  owned_->parse(std::move(words));
}

}  // namespace m100::companion
