// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/scenario/authority/program.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <thread>

extern char** environ;  // NOLINT: the name is POSIX

namespace m100::authority {
namespace {

namespace fs = std::filesystem;

/// Runs the program that follows with private mounts, in the same process.
constexpr std::array kOwnMounts{"unshare", "--user", "--map-root-user", "--mount"};

/// The arguments, after a shell that sets up what posix_spawn cannot.
std::vector<std::string> with_limits(const std::vector<std::string>& words, const Program::Streams& streams) {
  std::string set_up;
  if (streams.file_limit_bytes > 0) {
    set_up += "ulimit -f " + std::to_string(std::max(1L, streams.file_limit_bytes / 512)) + "; ";
  }
  if (!streams.small_disk.empty()) {
    set_up += "mount -t tmpfs -o size=256k none '" + streams.small_disk + "' || exit 2; ";
  }
  if (streams.output_closed) {
    set_up += "exec >&-; ";
  }
  if (set_up.empty()) {
    return words;
  }
  std::vector<std::string> shell{"/bin/sh", "-c", set_up + "exec \"$0\" \"$@\""};
  if (!streams.small_disk.empty()) {
    shell.insert(shell.begin(), kOwnMounts.begin(), kOwnMounts.end());
  }
  shell.insert(shell.end(), words.begin(), words.end());
  return shell;
}

}  // namespace

Program::Program(const std::vector<std::string>& words, const Streams& streams) {
  std::vector<std::string> command = with_limits(words, streams);
  std::vector<char*> pointers;
  std::transform(command.begin(), command.end(), std::back_inserter(pointers),
                 [](std::string& word) { return word.data(); });
  pointers.push_back(nullptr);
  std::array<int, 2> pipe_ends{-1, -1};
  if (::pipe2(pipe_ends.data(), O_CLOEXEC) != 0) {
    throw std::runtime_error("no pipe");
  }
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, pipe_ends[0], STDIN_FILENO);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, streams.said.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0644);
  posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
  const int failed = posix_spawnp(&id_, pointers[0], &actions, nullptr, pointers.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  ::close(pipe_ends[0]);
  input_ = pipe_ends[1];
  if (failed != 0) {
    ::close(input_);
    throw std::runtime_error(words.front() + ": " + std::strerror(failed));
  }
}

Program::~Program() {
  close_input();
  if (runs()) {
    ::kill(id_, SIGKILL);
    ::waitpid(id_, nullptr, 0);
  }
}

void Program::send(int signal) const {
  if (!ending_) {
    ::kill(id_, signal);
  }
}

pid_t Program::child(const std::string& name) const {
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator("/proc", error)) {
    std::ifstream file(entry.path() / "stat");  // number (name) state parent
    std::string text;
    std::getline(file, text);
    const std::size_t begin = text.find('(');
    const std::size_t end = text.rfind(')');
    if (begin != std::string::npos && end != std::string::npos && text.substr(begin + 1, end - begin - 1) == name &&
        std::stol(text.substr(end + 4)) == id_) {
      return static_cast<pid_t>(std::stol(text));
    }
  }
  return -1;
}

void Program::type(const std::string& words) const { (void)!::write(input_, words.data(), words.size()); }

void Program::close_input() {
  if (input_ >= 0) {
    ::close(input_);
    input_ = -1;
  }
}

bool Program::runs() { return !ending(); }

std::optional<int> Program::ending() {
  int status = 0;
  if (!ending_ && ::waitpid(id_, &status, WNOHANG) == id_) {
    ending_ = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }
  return ending_;
}

bool can_mount() {
  static const bool can = [] {
    Program::Streams streams;
    streams.small_disk = fs::temp_directory_path();
    streams.said = "/dev/null";
    Program mounts({"/bin/sh", "-c", "exit 0"}, streams);
    for (int waited = 0; mounts.runs() && waited < 1000; ++waited) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return mounts.ending() == 0;
  }();
  return can;
}

void end_all_in(const std::string& folder) {
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator("/proc", error)) {
    const std::string name = entry.path().filename().string();
    if (name.empty() || std::isdigit(static_cast<unsigned char>(name.front())) == 0) {
      continue;
    }
    std::ifstream file(entry.path() / "cmdline", std::ios::binary);
    std::string words;
    std::getline(file, words, '\x01');  // reads all; the process may end meanwhile
    if (words.find(folder) != std::string::npos) {
      ::kill(static_cast<pid_t>(std::stol(name)), SIGKILL);
    }
  }
}

}  // namespace m100::authority
