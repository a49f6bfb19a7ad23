// SPDX-License-Identifier: BSD-3-Clause
// m100-lab evening: one aircraft's folder from the first byte to the corrected flight; says what comes next.
#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>
#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "firmware/companion/version.h"
#include "host_tests/lab/evening/page.h"
#include "host_tests/lab/evening/steps.h"
#include "host_tests/lab/input_error.h"
#include "host_tests/lab/subcommands.h"

extern char** environ;  // NOLINT: the name is POSIX

namespace m100::lab {
namespace {

namespace fs = std::filesystem;
using evening::Command;
using evening::Folder;
using evening::Step;

struct Options {
  std::string folder;
  evening::Settings settings;
  bool list = false;
};

/// As one types it: words with other characters than these stand in quotes.
std::string typed(const Command& command) {
  std::string out;
  for (const std::string& word : command) {
    const bool plain =
        word.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_./:,=") ==
        std::string::npos;
    out += (out.empty() ? "" : " ") + (plain && !word.empty() ? word : "'" + word + "'");
  }
  return out;
}

/// Runs a program inside the folder; what it prints goes to `said`, its errors to ours. @returns its exit code.
int run_program(const Command& command, const std::string& folder, const std::string& said) {
  std::vector<std::string> words = command;
  std::vector<char*> pointers;
  for (std::string& word : words) {
    pointers.push_back(word.data());
  }
  pointers.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, said.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0644);
  pid_t child = -1;
  const int wrong = posix_spawnp(&child, pointers[0], &actions, nullptr, pointers.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  int status = 0;
  if (wrong != 0 || waitpid(child, &status, 0) != child) {
    throw InputError(command.front(), 0, "", "cannot be started; --m100 names the program m100 of this machine");
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

/// The evening as far as it goes without a person.
class Evening {
 public:
  explicit Evening(Folder& folder) : folder_(folder) {}

  /// Prints the steps and which are done, and does nothing.
  void list() {
    tell_changes();
    for (const Step& step : evening::steps(folder_)) {
      std::cout << (folder_.is_done(step.name) ? "done  " : "      ") << step.name << ": " << step.sentence << "\n";
    }
  }

  void run() {
    tell_changes();
    for (std::size_t at = 0; at < evening::steps(folder_).size(); ++at) {
      const Step step = evening::steps(folder_)[at];  // anew: commands depend on what is there by now
      if (folder_.is_done(step.name)) {
        continue;
      }
      if (step.on_board && folder_.was_taken(step.name, step.makes)) {
        put_aside(step);  // flown with files that are others now
      }
      if (step.on_board && !all_there(step)) {
        ask_for(step);
        return;
      }
      step.on_board ? take(step) : make(step);
    }
    finish();
  }

 private:
  bool all_there(const Step& step) const {
    return std::all_of(step.makes.begin(), step.makes.end(),
                       [&](const std::string& name) { return folder_.has(name); });
  }

  /// The next step is a person's.
  void ask_for(const Step& step) const {
    const std::string command = typed(step.commands.front());
    std::cout << "next: " << step.name << ". " << step.sentence << "\n"
              << "on the board, in a copy of " << folder_.path() << ":\n  " << command << "\n"
              << "then copy";
    for (const std::string& name : step.makes) {
      std::cout << " " << name;
    }
    std::cout << " back into the folder and call this again.\n";
    folder_.save(
        {{"step", step.name}, {"where", "board"}, {"sentence", step.sentence}, {"argv", step.commands.front()}});
  }

  /// A step that a person did.
  void take(const Step& step) { accept(step, step.judge(folder_)); }

  void make(const Step& step) {
    std::cout << step.name << ": " << step.sentence << std::endl;
    const std::string said = folder_.file(step.name + ".txt");
    fs::remove(said);
    std::string why;
    for (const Command& command : step.commands) {
      why = command.front() == "copy"     ? copy(command)
            : command.front() == "adjust" ? adjust(command)
                                          : run_one(step, command, fs::absolute(said).string());
      if (!why.empty()) {
        break;
      }
    }
    accept(step, why.empty() ? step.judge(folder_) : why);
  }

  std::string copy(const Command& command) const {
    std::error_code error;
    fs::copy_file(folder_.file(command[1]), folder_.file(command[2]), fs::copy_options::overwrite_existing, error);
    return error ? command[1] + ": cannot be copied to " + command[2] + ": " + error.message() : "";
  }

  std::string adjust(const Command& command) const {
    std::cout << "  " << command[1] << ": with calmer weights, or the trims of the hover" << std::endl;
    evening::adjust(folder_, command[1]);
    return "";
  }

  std::string run_one(const Step& step, Command command, const std::string& said) const {
    std::cout << "  " << typed(command) << std::endl;
    const bool own = command.front() == "m100-lab";
    command.front() = own ? fs::read_symlink("/proc/self/exe").string() : folder_.settings().m100;
    const int code = run_program(command, folder_.path(), said);
    return code == kDone
               ? ""
               : "the command ended with " + std::to_string(code) + "; what it said is in " + step.name + ".txt";
  }

  void accept(const Step& step, const std::string& why) {
    if (why.empty()) {
      folder_.done(step.name, step.makes, step.reads);
      folder_.save({{"step", ""}});
      std::cout << step.name << ": done\n";
      return;
    }
    std::cout << step.name << ": NOT PASSED: " << why << "\n";
    if (step.on_board) {
      put_aside(step);
      std::cout << "the step is to be done again; its files lie in " << folder_.file("not_passed") << "\n";
    }
    folder_.save({{"step", step.name},
                  {"where", step.on_board ? "board" : "pc"},
                  {"sentence", step.sentence},
                  {"argv", step.commands.front()},
                  {"not_passed", why}});
    throw CLI::RuntimeError(kAnswerIsNo);
  }

  /// A log is never overwritten: what did not pass makes room.
  void put_aside(const Step& step) {
    folder_.forget(step.makes);
    for (int number = 1; number < 1000; ++number) {
      const fs::path aside = fs::path(folder_.file("not_passed")) / (step.name + "." + std::to_string(number));
      if (!fs::exists(aside)) {
        fs::create_directories(aside);
        for (const std::string& name : step.makes) {
          fs::rename(folder_.file(name), aside / name);
        }
        return;
      }
    }
  }

  void tell_changes() {
    for (const std::string& change : folder_.look_for_changes()) {
      std::cout << "changed: " << change << "\n";
    }
  }

  void finish() const {
    evening::write_summary(folder_, companion::version());
    Command report{fs::read_symlink("/proc/self/exe").string(),
                   "report",
                   "--out",
                   "evening.html",
                   "--title",
                   "One evening with one aircraft",
                   "--lead",
                   "summary.html"};
    for (const char* const part : {"hand_roll/roll", "hand_pitch/pitch", "flown_roll/roll", "flown_pitch/pitch"}) {
      if (folder_.has(std::string(part) + ".html")) {
        report.push_back(std::string(part) + ".html");
      }
    }
    if (run_program(report, folder_.path(), "/dev/null") != kDone) {
      throw InputError(folder_.file("evening.html"), 0, "", "cannot be written");
    }
    const auto& numbers = folder_.numbers();
    std::cout << "the evening is over: " << 100.0 * numbers.at("pose_m.course") << " cm from the reference before, "
              << 100.0 * numbers.at("pose_m.corrected") << " cm after (root mean square, same course); "
              << folder_.file("evening.html") << "\n";
    folder_.save({{"step", "over"}});
  }

  Folder& folder_;
};

void run(const Options& options) {
  Folder folder(options.folder);
  evening::Settings& settings = folder.settings();
  if (folder.is_new()) {
    settings = options.settings;
    if (settings.port.empty() || settings.pose_port.empty()) {
      throw InputError(options.folder, 0, "",
                       "is new: say with --port and --pose-port what the board calls the autopilot's and the pose's "
                       "serial port");
    }
  } else if (!options.settings.port.empty() || !options.settings.pose_port.empty()) {
    settings.port = options.settings.port.empty() ? settings.port : options.settings.port;
    settings.pose_port = options.settings.pose_port.empty() ? settings.pose_port : options.settings.pose_port;
  }
  evening::lay_out(folder);
  Evening ahead(folder);
  options.list ? ahead.list() : ahead.run();
}

}  // namespace

void add_evening(CLI::App& lab) {
  CLI::App* const command = lab.add_subcommand(
      "evening", "one aircraft from the first byte to the corrected flight: says the next step, does the PC's itself");
  const auto options = std::make_shared<Options>();
  evening::Settings& settings = options->settings;
  command->add_option("folder", options->folder, "of this aircraft; made where there is none")->required();
  command->add_option("--port", settings.port, "serial port of the autopilot, as the board names it");
  command->add_option("--pose-port", settings.pose_port, "serial port of the pose");
  command->add_option("--baud", settings.baud, "as set in DJI's assistant")
      ->check(CLI::IsMember({115200, 230400, 460800, 921600}));
  command->add_option("--pose-baud", settings.pose_baud, "of the pose's port")
      ->check(CLI::IsMember({115200, 230400, 460800, 921600}));
  command->add_option("--app-id", settings.app_id, "from DJI's developer site");
  command->add_option("--key-file", settings.key_file, "on the board: the app's key; encrypts commands");
  command->add_option("--m100", settings.m100, "the program m100 on this machine, for the step `check`");
  command->add_flag("--list", options->list, "print the steps and which are done; do nothing");
  command->callback([options] { run(*options); });
}

}  // namespace m100::lab
