// SPDX-License-Identifier: BSD-3-Clause
// m100-lab evening: guides one aircraft, in one folder, from the first byte to the corrected flight, step by step.
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>
#include <utility>

#include "firmware/companion/command_line.h"
#include "firmware/companion/files/text/json.h"
#include "firmware/companion/files/vehicle_file.h"
#include "host_tests/lab/evening/board.h"
#include "host_tests/lab/evening/corrected_vehicle.h"
#include "host_tests/lab/evening/flight_result.h"
#include "host_tests/lab/evening/initial_files.h"
#include "host_tests/lab/evening/law_comparison.h"
#include "host_tests/lab/evening/run_program.h"
#include "host_tests/lab/evening/steps.h"
#include "host_tests/lab/evening/summary_page.h"
#include "host_tests/lab/input_error.h"
#include "host_tests/lab/interruption.h"
#include "host_tests/lab/subcommands.h"
#include "host_tests/lab/whole_file.h"

namespace m100::lab {
namespace {

namespace fs = std::filesystem;
constexpr int kNotFound = 127;  ///< a shell's exit code if it does not find the program
using evening::Command;
using evening::Folder;
using evening::Step;

struct EveningOptions {
  std::string folder;
  evening::Settings settings;
  std::string board;  ///< where ssh reaches the board; empty: a person runs its commands and copies the files
  bool list = false;
};

/// Runs the steps of an evening until one needs a person.
class Evening {
 public:
  /// @param board where ssh reaches the board; empty: a person runs its commands
  explicit Evening(Folder& folder, std::string board = "") : folder_(folder), destination_(std::move(board)) {}

  /// Prints the steps and which of them are done; runs none.
  /// @param busy another process works in the folder; the first step that is not done is then marked
  void list(bool busy) {
    report_changes();
    for (const Step& step : evening::steps(folder_)) {
      const bool done = folder_.is_done(step.name);
      const char* const mark = done ? "done  " : std::exchange(busy, false) ? "now   " : "      ";
      std::cout << mark << step.name << ": " << step.sentence << "\n";
    }
  }

  void run() {
    report_changes();
    for (std::size_t at = 0; at < evening::steps(folder_).size(); ++at) {
      const Step step = evening::steps(folder_)[at];  // read again: the commands depend on the files made so far
      if (folder_.is_done(step.name)) {
        continue;
      }
      if (step.on_board && folder_.was_taken(step.name, step.makes)) {
        folder_.put_aside(step.name, step.makes);  // it was flown with files that have changed since
      }
      if (step.on_board && !all_there(step) && !fetched(step)) {
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

  /// Runs the step on the board, unless it was run, and fetches its files. @returns false: it waits for a person.
  bool fetched(const Step& step) {
    if (destination_.empty()) {
      ask_for(step);
      return false;
    }
    if (board_ == nullptr) {
      board_ = std::make_unique<evening::Board>(destination_, folder_.path());
    }
    if (!board_->has_result(step)) {
      note_next(step);
      std::cout << "next: " << step.name << ". " << step.sentence << "\n  " << evening::typed(step.commands.front())
                << "\nEnter runs it on the board; Ctrl-C stops here, the same command goes on" << std::endl;
      if (std::string line; !std::getline(std::cin, line)) {
        return false;
      }
      const int code = run_on_board(step);
      if (!board_->has_result(step)) {
        reject(step, code == kNotFound ? "the board has no program m100: install its package there"
                                       : "the command ended with exit code " + std::to_string(code) +
                                             " and has not made all its files");
      }
    }
    board_->fetch(step);
    return true;
  }

  int run_on_board(const Step& step) const {
    std::unique_ptr<evening::SideProgram> beside;
    if (Command command = evening::bridge_command(folder_.settings()); !command.empty()) {
      command.front() = fs::read_symlink("/proc/self/exe").string();
      beside = std::make_unique<evening::SideProgram>(command, folder_.path(), "bridge.txt");
    }
    return board_->run(step);
  }

  /// Tells the person what the next step is and how to do it.
  void ask_for(const Step& step) const {
    const std::string command = evening::typed(step.commands.front());
    std::cout << "next: " << step.name << ". " << step.sentence << "\n"
              << "on the board, in a copy of " << fs::canonical(folder_.path()).string() << ":\n  " << command << "\n";
    if (const Command bridge = evening::bridge_command(folder_.settings()); !bridge.empty()) {
      std::cout << "beside it, on this machine, until it has ended:\n  " << evening::typed(bridge) << "\n";
    }
    std::cout << "then copy";
    for (const std::string& name : step.makes) {
      std::cout << " " << name;
    }
    std::cout << " back into the folder and run this command again.\n";
    report_interruption(step);
    note_next(step);
  }

  void note_next(const Step& step) const {
    folder_.save(
        {{"step", step.name}, {"where", "board"}, {"sentence", step.sentence}, {"argv", step.commands.front()}});
  }

  /// Tells what is missing if only some of the step's files are there: the copy or the command was interrupted.
  void report_interruption(const Step& step) const {
    std::string there, missing;
    for (const std::string& name : step.makes) {
      (folder_.has(name) ? there : missing) += " " + name;
    }
    if (!there.empty()) {
      std::cout << "already in the folder:" << there << "; missing:" << missing
                << ". Copy the missing files too. If the command was interrupted, first remove" << there
                << " here and on the board: a log is never overwritten\n";
    }
  }

  /// Checks the files of a step that ran on the board.
  void take(const Step& step) {
    const std::string wrong = step.makes.back() + " is not what this command writes; was it copied completely?";
    std::string why = evening::differing_input(folder_, step.name, step.reads);
    try {
      why = !why.empty()                                             ? why
            : evening::result_of(folder_, step.makes.back()).empty() ? wrong
                                                                     : step.evaluate(folder_);
    } catch (const JsonError&) {
      why = wrong;
    }
    accept(step, why);
  }

  void make(const Step& step) {
    std::cout << step.name << ": " << step.sentence << std::endl;
    const std::string said = folder_.file(step.name + ".txt");
    fs::remove(said);
    std::string why;
    for (const Command& command : step.commands) {
      why = run(step, command, fs::absolute(said).string());
      if (!why.empty()) {
        break;
      }
    }
    accept(step, why.empty() ? step.evaluate(folder_) : why);
  }

  /// Runs one command of a step on this machine. @returns why it failed; empty: it did not, or "try" allows it to fail.
  std::string run(const Step& step, const Command& command, const std::string& said) {
    const std::string& verb = command.front();
    if (verb == "copy") {
      companion::load_vehicle(folder_.file(command[1]));  // an error names the file that a person may have changed
      evening::write_file(folder_.file(command[2]), whole_file(folder_.file(command[1])));
      return "";
    }
    if (verb == "adjust") {
      std::cout << "  " << command[1] << ": set the calmer weights or the trims of the hover" << std::endl;
      evening::adjust(folder_, command[1]);
      return "";
    }
    if (verb == "take_over") {
      evening::write_corrected_vehicle(folder_);
      return "";
    }
    if (verb == "compare_laws") {
      std::cout << "  comparing both laws on the corrected model, in simulated pairs of flights" << std::endl;
      evening::compare_laws(folder_);
      return "";
    }
    if (verb == "try") {
      if (const std::string why = run_one(step, Command(command.begin() + 1, command.end()), said); !why.empty()) {
        std::cout << "  the evening goes on: " << why << std::endl;
      }
      return "";
    }
    return run_one(step, command, said);
  }

  std::string run_one(const Step& step, Command command, const std::string& said) const {
    std::cout << "  " << evening::typed(command) << std::endl;
    const bool own = command.front() == "m100-lab";
    command.front() = own ? fs::read_symlink("/proc/self/exe").string() : folder_.settings().m100;
    const int code = evening::run_program(command, folder_.path(), {.out = said});
    return code == companion::kDone ? ""
                                    : "the command ended with exit code " + std::to_string(code) +
                                          "; its output is in " + step.name + ".txt";
  }

  void accept(const Step& step, const std::string& why) {
    if (why.empty()) {
      folder_.done(step.name, step.makes, step.reads);
      folder_.save({{"step", ""}});
      std::cout << step.name << ": done\n";
      return;
    }
    if (step.on_board) {
      folder_.put_aside(step.name, step.makes);
      std::cout << "this step must be done again; its files are now in " << folder_.file("not_passed") << "\n";
    }
    reject(step, why);
  }

  /// Prints why the step failed, saves that in the evening's folder, and ends the program with exit code 1.
  [[noreturn]] void reject(const Step& step, const std::string& why) const {
    std::cout << step.name << ": NOT PASSED: " << why << "\n";
    folder_.save({{"step", step.name},
                  {"where", step.on_board ? "board" : "pc"},
                  {"sentence", step.sentence},
                  {"argv", step.commands.front()},
                  {"not_passed", why}});
    throw companion::AnswerIsNo();
  }

  void report_changes() {
    for (const std::string& change : folder_.look_for_changes()) {
      std::cout << "changed: " << change << "\n";
    }
  }

  /// Runs `m100-lab WORDS --out PAGE` in the folder. Errors: InputError.
  void make_page(Command words, const std::string& page) const {
    words.insert(words.begin(), fs::read_symlink("/proc/self/exe").string());
    words.insert(words.end(), {"--out", page});
    if (evening::run_program(words, folder_.path(), {.out = "/dev/null"}) != companion::kDone) {
      throw InputError(folder_.file(page), 0, "", "cannot be written");
    }
  }

  void finish() const {
    evening::write_summary(folder_);
    Command flights{"flight", std::string(evening::kBefore) + ".ulg", std::string(evening::kAfter) + ".ulg", "--title",
                    "The course before and after the correction"};
    if (folder_.settings().flights > 1) {
      flights.insert(flights.end(),
                     {"--note", "The first flight before and the first after; the summary compares all."});
    }
    make_page(std::move(flights), "flights.html");
    Command report{"report", "--title", "One evening with one aircraft", "--lead", "summary.html", "flights.html"};
    for (const char* const part : {"hand_roll/roll", "hand_pitch/pitch", "flown_roll/roll", "flown_pitch/pitch",
                                   "flown_climb/climb", "flown_yaw_rate/yaw_rate"}) {
      if (folder_.has(std::string(part) + ".html")) {
        report.push_back(std::string(part) + ".html");
      }
    }
    make_page(report, "evening.html");
    std::cout
        << "the evening is complete; errors on the same course before and after the correction, root mean square:\n"
        << evening::before_and_after(folder_) << folder_.file("evening.html") << "\n";
    folder_.save({{"step", "over"}});
  }

  Folder& folder_;
  std::string destination_;
  std::unique_ptr<evening::Board> board_;  ///< null until a step needs it
};

/// Replaces the settings of the folder by those that the command line gives.
void take_given(const companion::Subcommand& command, const evening::Settings& from, evening::Settings& to) {
  evening::for_each_setting([&](const char* option, const char*, bool, const auto& member) {
    member(to) = command.is_given(option) ? member(from) : member(to);
  });
}

void run(const companion::Subcommand& command, const EveningOptions& options) {
  const bool is_new = !fs::exists(fs::path(options.folder) / "evening.json");
  if (is_new && options.list) {
    throw InputError(options.folder, 0, "--list", "no evening has begun in this folder");
  }
  if (is_new && fs::is_directory(options.folder) && !fs::is_empty(options.folder) &&
      !fs::exists(fs::path(options.folder) / "columns_hand.toml")) {  // the first file of an evening
    throw InputError(options.folder, 0, "", "holds other files: name a new or an empty folder");
  }
  if (is_new && (options.settings.port.empty() || options.settings.pose.port.empty())) {
    throw InputError(options.folder, 0, "",
                     "is a new folder: give the ports of the autopilot (--port) and of the pose (--pose-port), as the "
                     "board names them");
  }
  if (is_new) {
    evening::check_ports(options.settings);
  }
  if (options.list) {
    const bool is_busy = evening::FolderLock::is_held(options.folder);
    Folder folder(options.folder);
    Evening(folder).list(is_busy);
    return;
  }
  Command again{"m100-lab", "evening", options.folder};
  if (!options.board.empty()) {
    again.insert(again.end(), {"--board", options.board});
  }
  explain_interruption("\nstopped; nothing is lost: " + evening::typed(again) + " goes on with this step\n");
  const evening::FolderLock lock(evening::made(options.folder));
  Folder folder(options.folder);
  take_given(command, options.settings, folder.settings());
  evening::check_ports(folder.settings());
  const auto not_kept = [&](const auto& number) { return number.first.starts_with("kept.") && number.second == 0.0; };
  if (folder.settings().keep_worse && std::ranges::any_of(folder.numbers(), not_kept)) {
    folder.again("gains_again");
  }
  evening::write_initial_files(folder);
  Evening(folder, options.board).run();
}

}  // namespace

void add_evening(companion::CommandLine& lab) {
  const companion::Subcommand command = lab.add_subcommand(
      "evening",
      "guide one aircraft from the first byte to the corrected flight: name the next step, run the PC's steps");
  const auto options = std::make_shared<EveningOptions>();
  evening::Settings& settings = options->settings;
  command.add_option("folder", options->folder, "folder of this aircraft; created if it does not exist").required();
  command.add_option("--port", settings.port, "serial port of the autopilot, as the board names it");
  command.add_option("--baud", settings.baud, "baud rate of the autopilot's port, as set in DJI's assistant")
      .one_of({115200, 230400, 460800, 921600});
  companion::add_pose_options(command, settings.pose);
  command.add_option(
      "--bridge", settings.bridge,
      "options of m100-lab bridge, which then sends the poses from this machine while a step runs on the board. "
      "Example: --bridge '--vrpn m100@192.168.1.10 --to 192.168.1.20:14560'");
  command.add_option("--app-id", settings.app_id, "app id from DJI's developer site");
  command
      .add_option("--flights", settings.flights,
                  "flights of the course, before and after the correction; two or more give the difference an "
                  "interval")
      .in_range(1, 20);
  command.add_option("--key-file", settings.key_file,
                     "file with the app's key, on the board; commands are then encrypted");
  command.add_flag("--keep-worse", settings.keep_worse,
                   "take the corrected law even if it is worse as flown; else that of vehicle.toml stays");
  command.add_option("--m100", settings.m100, "the program m100 on this machine, for the step `check`");
  command
      .add_option(
          "--board", options->board,
          "where ssh reaches the board: USER@HOST or ssh://USER@HOST:PORT; its commands then run there, on this "
          "terminal, and files are copied; default: you do both")
      .check([](const std::string& word) {
        return word.rfind('-', 0) == 0 ? "--board: '" + word + "' is no USER@HOST" : std::string();
      });
  command.add_flag("--list", options->list, "print the steps and which are done; run none");
  command.callback([command, options] { run(command, *options); });
}

}  // namespace m100::lab
