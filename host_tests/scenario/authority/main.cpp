// SPDX-License-Identifier: BSD-3-Clause
// The battery: the installed programs under every fault, judged by the autopilot's events (promises R4, R12, R15).
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <string>

#include "host_tests/scenario/authority/battery.h"

namespace m100::authority {
namespace {

constexpr const char* kUsage =
    "usage: m100_authority_battery --m100 PROGRAM --lab PROGRAM --vehicle V.toml --gains TABLE\n"
    "                   [--battery short|whole|counted|losses] [--only TEXT] [--open FILE] [--jobs N] [--json O.json]\n"
    "--only: only cases whose name contains the text. --open: file of known failures, lines 'part of a case | part of "
    "the violation'.\n"
    "--folder: for the files of failed cases; default: a temporary folder. --keep all: keeps the files of every case.\n"
    "Prints the table of host_tests/sim/README.md at its end. Exit code 1: a case failed that is no known failure.\n";

std::vector<std::string> lines_of(const std::string& path) {
  std::ifstream file(path);
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) {
    line = line.substr(0, line.find('#'));
    line = line.substr(0, line.find_last_not_of(" \t\r") + 1);
    if (!line.empty()) {
      lines.push_back(line);
    }
  }
  return lines;
}

/// A short name, because the path of a socket may have at most 107 characters.
std::string temporary_folder() {
  return (std::filesystem::temp_directory_path() / ("m100_sticks_" + std::to_string(::getpid()))).string();
}

std::vector<Case> battery(const std::string& name) {
  return name == "losses"    ? losses_battery()
         : name == "whole"   ? whole_battery()
         : name == "counted" ? counted_battery()
                             : short_battery();
}

/// Prepares an empty folder for the cases, and collects the paths of the programs and files.
Places places_of(std::map<std::string, std::string>& options) {
  Places places{.m100 = options["--m100"],
                .lab = options["--lab"],
                .vehicle = options["--vehicle"],
                .gains = options["--gains"],
                .folder = options["--folder"].empty() ? temporary_folder() : options["--folder"],
                .keep = options["--keep"] == "all"};
  std::filesystem::remove_all(places.folder);
  std::filesystem::create_directories(places.folder);
  return places;
}

int run(std::map<std::string, std::string> options) {
  for (const char* const needed : {"--m100", "--lab", "--vehicle", "--gains"}) {
    if (options[needed].empty()) {
      std::cerr << kUsage;
      return 2;
    }
  }
  const bool is_losses = options["--battery"] == "losses";
  std::vector<Case> cases = battery(options["--battery"]);
  std::erase_if(cases, [&](const Case& one) { return one.name().find(options["--only"]) == std::string::npos; });
  const Places places = places_of(options);
  const std::size_t jobs = options["--jobs"].empty() ? 4 : std::stoul(options["--jobs"]);
  if (!can_mount()) {
    std::cout << "left out: cases that need a private file system (no user namespaces here)\n";
  }
  const std::vector<Result> results = fly_all(cases, places, jobs, lines_of(options["--open"]), std::cout);
  std::cout << "\n" << (is_losses ? losses_table(results) : matrix(results));
  if (!options["--json"].empty()) {
    std::ofstream(options["--json"]) << to_json(results) << "\n";
  }
  const auto count = [&](auto&& condition) { return std::count_if(results.begin(), results.end(), condition); };
  const auto failed = count([](const Result& result) { return !result.passed() && !result.open; });
  std::cout << "\n"
            << results.size() << " cases, " << count([](const Result& result) { return result.passed(); })
            << " passed, " << failed << " failed, "
            << count([](const Result& result) { return !result.passed() && result.open; }) << " open\n";
  return failed == 0 && !results.empty() && (!is_losses || losses_hold(results)) ? 0 : 1;
}

}  // namespace
}  // namespace m100::authority

int main(int argc, char** argv) {
  std::signal(SIGPIPE, SIG_IGN);  // for writing to a program that has ended
  std::map<std::string, std::string> options;
  for (int i = 1; i + 1 < argc; i += 2) {
    options[argv[i]] = argv[i + 1];
  }
  if (argc % 2 == 0) {
    options.clear();
  }
  return m100::authority::run(std::move(options));
}
