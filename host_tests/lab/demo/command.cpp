// SPDX-License-Identifier: BSD-3-Clause
// m100-lab demo: replaces itself by the demonstration, a script that is installed beside the program.
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <iostream>

#include "firmware/companion/command_line.h"
#include "firmware/companion/files/file_use.h"
#include "host_tests/lab/input_error.h"
#include "host_tests/lab/subcommands.h"

namespace m100::lab {
namespace {

struct DemoOptions {
  std::string out = "m100_demo";
  std::string logs;
};

/// Does not return. Errors: InputError if the script is not installed, or a folder cannot be used.
void become_demonstration(const DemoOptions& options) {
  namespace fs = std::filesystem;
  companion::FileUse().fills("--out", options.out, "report.html").check();
  const auto has = [logs = fs::path(options.logs)](const char* name) { return fs::exists(logs / name); };
  if (!options.logs.empty() && !(has("pitch_roll.csv") && has("height.csv")) &&
      !(has("ExperimentPitchRoll.mat") && has("ExperimentHeight.mat"))) {
    throw InputError(options.logs, 0, "--logs",
                     "has neither pitch_roll.csv and height.csv nor ExperimentPitchRoll.mat and ExperimentHeight.mat");
  }
  std::string program = fs::read_symlink("/proc/self/exe").string();
  std::string script = (fs::path(program).parent_path().parent_path() / "share/m100-lab/demonstration").string();
  std::string out = options.out, logs = options.logs;
  char* const words[] = {script.data(), program.data(), out.data(), logs.empty() ? nullptr : logs.data(), nullptr};
  std::cout.flush();
  execv(words[0], words);
  throw InputError(script, 0, "",
                   std::string(std::strerror(errno)) +
                       "; the demonstration needs an installed m100-lab (cmake --install, or the package)");
}

}  // namespace

void add_demo(companion::CommandLine& lab) {
  const auto [command, options] = lab.add_subcommand<DemoOptions>(
      "demo",
      "run the demonstration: identify a log, find the residual, compute gains, fly (minutes); writes report.html",
      become_demonstration);
  command.add_option("--out", options->out, "folder for the page and everything that leads to it");
  command
      .add_option(
          "--logs", options->logs,
          "folder with the measured flights: pitch_roll.csv and height.csv, or the published "
          "ExperimentPitchRoll.mat and ExperimentHeight.mat, with the former perhaps falcon2_height.csv and its map "
          "falcon2.toml; default: a simulated flight with a hidden effect")
      .existing_folder();
}

}  // namespace m100::lab
