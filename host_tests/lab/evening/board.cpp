// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/evening/board.h"

#include <cstdlib>
#include <filesystem>
#include <utility>
#include <vector>

#include "host_tests/lab/evening/run_program.h"
#include "host_tests/lab/input_error.h"

namespace m100::lab::evening {
namespace {

namespace fs = std::filesystem;

constexpr int kSshFailed = 255;  ///< ssh's exit code for its own failures

/// A shell command that succeeds if all these files exist.
std::string all_exist(const std::vector<std::string>& names) {
  std::string out = "true";
  for (const std::string& name : names) {
    out += " && [ -e " + typed({name}) + " ]";
  }
  return out;
}

}  // namespace

Board::Board(std::string destination, std::string folder)
    : destination_(std::move(destination)), folder_(fs::absolute(folder).lexically_normal().string()) {
  std::string name = (fs::temp_directory_path() / "m100-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) {
    throw InputError(name, 0, "", "cannot be created");
  }
  control_ = name;
}

Board::~Board() {
  try {
    run_program({"ssh", "-q", "-o", "ControlPath=" + control_ + "/%C", "-O", "exit", "--", destination_}, "/",
                {.in = "/dev/null", .out = "/dev/null"});
  } catch (const InputError&) {
    // Without ssh there is no connection to end.
  }
  std::error_code ignored;
  fs::remove_all(control_, ignored);
}

int Board::call(const std::string& shell, const std::string& in, const std::string& out, Terminal terminal) const {
  const fs::path name = fs::path(folder_).has_filename() ? fs::path(folder_).filename() : fs::path("evening");
  const std::string there = typed({"m100_evening/" + name.string()});
  Command ssh{"ssh", "-o", "ControlMaster=auto", "-o", "ControlPersist=60", "-o", "ControlPath=" + control_ + "/%C"};
  ssh.push_back(terminal == Terminal::kOwn ? "-tt" : "-T");
  ssh.insert(ssh.end(), {"--", destination_, "mkdir -p " + there + " && cd " + there + " && { " + shell + "; }"});
  const bool asks = terminal == Terminal::kOwn;
  const int code = run_program(ssh, folder_, {.in = in.empty() && !asks ? "/dev/null" : in, .out = out});
  if (code == kSshFailed) {
    throw InputError("--board " + destination_, 0, "",
                     "not reached by ssh, or the connection was lost (the program on the board then gives control "
                     "back); run this command again: it fetches what is complete there");
  }
  return code;
}

bool Board::has_result(const Step& step) const { return call(all_exist(step.makes)) == 0; }

int Board::run(const Step& step) const {
  for (const std::string& name : step.reads) {
    const std::string partial = name + ".partial";
    if (call("cat >" + typed({partial}) + " && mv " + typed({partial, name}), name, "", Terminal::kNone) != 0) {
      throw InputError(name, 0, "", "cannot be written on the board: its disk is full, or a permission is missing");
    }
  }
  const std::string aside =
      "for name in " + typed(step.makes) +
      "; do [ ! -e \"$name\" ] || { mkdir -p not_passed && mv \"$name\" \"not_passed/$name.$(date "
      "+%s)\"; }; done; ";
  return call(aside + "exec " + typed(step.commands.front()), "", "", Terminal::kOwn);
}

void Board::fetch(const Step& step) const {
  for (const std::string& name : step.makes) {
    const fs::path partial = fs::path(folder_) / (name + ".partial");
    fs::remove(partial);
    if (call("cat " + typed({name}), "", partial.string(), Terminal::kNone) != 0) {
      throw InputError(name, 0, "", "cannot be read on the board");
    }
  }
  for (const std::string& name : step.makes) {
    fs::rename(fs::path(folder_) / (name + ".partial"), fs::path(folder_) / name);
  }
  call("rm -f " + typed(step.makes));
}

}  // namespace m100::lab::evening
