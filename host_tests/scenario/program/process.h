// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

extern char** environ;  // NOLINT: the name is POSIX

namespace m100::scenario {

constexpr std::chrono::seconds kPatience{300};  ///< for a program on a busy machine; no verdict depends on it

/// Waits until the condition holds. @returns whether it does.
template <typename Condition>
bool wait_until(const Condition& holds, std::chrono::seconds at_most = kPatience) {
  for (auto left = at_most / std::chrono::milliseconds(10); !holds(); --left) {
    if (left <= 0) {
      return false;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return true;
}

/// The words of a command line.
using Words = std::vector<std::string>;

inline Words with(Words words, const Words& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

/// The program that a test starts: `program`, but for the shipped program the one that M100_INSTEAD names, if it is
/// set. In this way whole tests run the build that counts allocations.
inline std::string started(const std::string& program) {
#ifdef M100_PROGRAM
  const char* const instead = std::getenv("M100_INSTEAD");
  return instead != nullptr && program == M100_PROGRAM ? instead : program;
#else
  return program;
#endif
}

/// A program as a user starts it; it is killed at the end of the test if it still runs.
class Process {
 public:
  /// @param errors file for stderr; empty: the test's own stderr.
  /// @param output descriptor for stdout; -1: the test's own stdout. @param input for stdin likewise.
  Process(const std::string& program, const Words& more, const std::filesystem::path& errors = {}, int output = -1,
          int input = -1) {
    Words arguments = with({started(program)}, more);
    std::vector<char*> pointers;
    pointers.reserve(arguments.size() + 1);
    for (std::string& argument : arguments) {
      pointers.push_back(argument.data());
    }
    pointers.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    if (!errors.empty()) {
      posix_spawn_file_actions_addopen(&actions, 2, errors.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    }
    if (output >= 0) {
      posix_spawn_file_actions_adddup2(&actions, output, 1);
    }
    if (input >= 0) {
      posix_spawn_file_actions_adddup2(&actions, input, 0);
    }
    EXPECT_EQ(posix_spawnp(&id_, pointers[0], &actions, nullptr, pointers.data(), environ), 0) << pointers[0];
    posix_spawn_file_actions_destroy(&actions);
  }
  ~Process() {
    if (id_ > 0) {
      kill(id_, SIGKILL);
      waitpid(id_, nullptr, 0);
    }
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  pid_t id() const { return id_; }
  void send(int signal) const { kill(id_, signal); }
  void interrupt() const { send(SIGINT); }
  /// @returns the exit code; -1 if it did not end in time or not by itself. Zero seconds only ask whether it has ended.
  int wait(std::chrono::seconds at_most = kPatience) {
    int status = 0;
    if (!wait_until([&] { return waitpid(id_, &status, WNOHANG) == id_; }, at_most)) {
      return -1;
    }
    id_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

 private:
  pid_t id_ = -1;
};

}  // namespace m100::scenario
