// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <initializer_list>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "firmware/companion/subcommands.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace m100::companion {

// The command lines of all programs. Only command_line.cpp includes CLI11: its headers cost more than most of the
// sources that have options.

/// An option, or a word that needs no name. Each function returns it again; other options are named as `--port`, and
/// must be there already.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}

  Option required() const;
  Option needs(const std::string& other) const;
  Option excludes(const std::string& other) const;
  Option one_of(const std::vector<std::string>& words) const;
  Option one_of(std::initializer_list<int> numbers) const;
  Option in_range(double low, double high) const;  ///< both included; "nan" is inside
  Option in_range(int low, int high) const;
  Option from_to(double low, double high) const;  ///< both included; "nan" is not inside
  Option positive() const;
  Option whole_number() const;  ///< digits alone: "-1" would become a large number without a sign
  Option existing_file() const;
  Option existing_folder() const;
  /// @param wrong what is wrong with a word; empty: nothing. @param description shown by --help
  Option check(const std::function<std::string(const std::string& word)>& wrong,
               const std::string& description = "") const;
  /// Each word is replaced before it is checked.
  Option replaced_by(const std::function<std::string(const std::string& word)>& present) const;
  Option takes(int words) const;                    ///< a list of just so many words
  Option takes_one_each() const;                    ///< a list that grows by one word whenever the option is repeated
  Option takes_commas() const;                      ///< a list whose words are separated by commas
  Option type_name(const std::string& name) const;  ///< shown by --help

 private:
  CLI::Option* option_;
};

/// A program's command line or one of its subcommands. A copy is the same subcommand.
class Subcommand {
 public:
  explicit Subcommand(CLI::App* app) : app_(app) {}

  Subcommand add_subcommand(const std::string& name, const std::string& description) const;
  /// The same, with its options, which live as long as it does. @param run is called if the command line names it.
  template <typename Options>
  std::pair<Subcommand, std::shared_ptr<Options>> add_subcommand(const std::string& name,
                                                                 const std::string& description,
                                                                 void (*run)(const Options&)) const {
    const Subcommand command = add_subcommand(name, description);
    auto options = std::make_shared<Options>();
    command.callback([run, options] { run(*options); });
    return {command, options};
  }
  void require_subcommand() const;
  void footer(const std::string& text) const;  ///< the last words of --help
  void callback(const std::function<void()>& run) const;

  /// @param names "--port"; "log" for a word without a name; "--log,log" for both
  /// @param value takes the word; lives as long as the subcommand. command_line.cpp lists its types.
  template <typename Value>
  Option add_option(const std::string& names, Value& value, const std::string& description) const;
  Option add_flag(const std::string& name, bool& value, const std::string& description) const;
  /// An option that --help does not show, and that is refused: it is gone. @param why the message after its name
  void add_former_flag(const std::string& name, const std::string& why) const;
  /// None of the options that are there so far may be given beside this one.
  void exclude_others(const std::string& name) const;

  bool is_given(const std::string& name) const;

 protected:
  CLI::App* app_;
};

struct Example {
  std::string_view command;  ///< the words of the subcommand: "fly", "mpc solve"
  std::string_view line;     ///< a whole command line that does something useful
};

/// The command line of a program, without subcommands at first.
class CommandLine : public Subcommand {
 public:
  explicit CommandLine(const std::string& description);
  ~CommandLine();
  CommandLine(const CommandLine&) = delete;
  CommandLine& operator=(const CommandLine&) = delete;

  void show_defaults();                       ///< --help shows the default of each option that is added from now on
  void set_version(const std::string& text);  ///< what --version prints

  /// Runs the subcommand that the words of main() name. @param examples end the --help of their subcommands.
  /// @param flights subcommands whose exit code does not depend on whether the output could be written.
  /// @returns the program's exit code; bad input is a line on stderr.
  int run(const std::string& program, std::span<const Example> examples, std::span<char*> words,
          std::span<const std::string_view> flights = {});
  /// Reads the words of main(), for a program without subcommands. Ends it after --help, and after what is wrong.
  void read(int count, char** words);
  /// Reads the words after the program's, and runs the subcommand. Errors: std::exception with the message.
  void parse(std::vector<std::string> words);

 private:
  std::unique_ptr<CLI::App> owned_;
};

}  // namespace m100::companion
