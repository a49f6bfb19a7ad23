// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/evening/run_program.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/file.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "host_tests/lab/input_error.h"

extern char** environ;  // NOLINT: the name is POSIX

namespace m100::lab::evening {

std::string typed(const std::vector<std::string>& command) {
  std::string out;
  for (const std::string& word : command) {
    const bool plain =
        word.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_./:,=") ==
        std::string::npos;
    std::string quoted;
    for (const char letter : word) {
      quoted += letter == '\'' ? std::string("'\\''") : std::string(1, letter);
    }
    out += (out.empty() ? "" : " ") + (plain && !word.empty() ? word : "'" + quoted + "'");
  }
  return out;
}

int run_program(const std::vector<std::string>& command, const std::string& folder, const std::string& log_file) {
  std::vector<std::string> words = command;
  std::vector<char*> pointers;
  pointers.reserve(words.size() + 1);
  for (std::string& word : words) {
    pointers.push_back(word.data());
  }
  pointers.push_back(nullptr);
  const int out = open(log_file.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (out < 0) {
    throw InputError(log_file, 0, "", std::string("cannot be written: ") + std::strerror(errno));
  }
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
  posix_spawn_file_actions_adddup2(&actions, out, STDOUT_FILENO);
  pid_t child = -1;
  const int wrong = posix_spawnp(&child, pointers[0], &actions, nullptr, pointers.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  close(out);
  int status = 0;
  if (wrong != 0 || waitpid(child, &status, 0) != child) {
    throw InputError(command.front(), 0, "", "cannot be started; use --m100 to name the program m100 on this machine");
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

FolderLock::FolderLock(const std::string& folder) : descriptor_(open(folder.c_str(), O_RDONLY | O_DIRECTORY)) {
  if (descriptor_ < 0) {
    throw InputError(folder, 0, "", std::string("cannot be opened: ") + std::strerror(errno));
  }
  // Not closed on exec, so that started programs keep the lock.
  if (flock(descriptor_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    close(descriptor_);
    throw InputError(
        folder, 0, "",
        "another evening works in this folder, or the last command of a killed evening does; run this again "
        "when it has ended");
  }
}

FolderLock::~FolderLock() { close(descriptor_); }

}  // namespace m100::lab::evening
