// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/evening/run_program.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/file.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>

#include "host_tests/lab/input_error.h"
#include "host_tests/lab/interruption.h"

extern char** environ;  // NOLINT: the name is POSIX

namespace m100::lab::evening {

std::string typed(const std::vector<std::string>& command) {
  std::string out;
  for (const std::string& word : command) {
    const bool plain =
        word.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_./:,=@") ==
        std::string::npos;
    std::string quoted;
    for (const char letter : word) {
      quoted += letter == '\'' ? std::string("'\\''") : std::string(1, letter);
    }
    out += (out.empty() ? "" : " ") + (plain && !word.empty() ? word : "'" + quoted + "'");
  }
  return out;
}

namespace {

/// Opens a file for a child. @returns its descriptor; -1: no file is named. Errors: InputError.
int opened(const std::string& path, int flags, const char* what) {
  const int descriptor = path.empty() ? -1 : open(path.c_str(), flags | O_CLOEXEC, 0644);
  if (descriptor < 0 && !path.empty()) {
    throw InputError(path, 0, "", std::string("cannot be ") + what + ": " + std::strerror(errno));
  }
  return descriptor;
}

/// A command's words as the system takes them, with the null at their end.
std::vector<char*> pointers_to(std::vector<std::string>& words) {
  std::vector<char*> out(words.size() + 1, nullptr);
  std::ranges::transform(words, out.begin(), [](std::string& word) { return word.data(); });
  return out;
}

/// Opens the folder that is locked. Errors: InputError.
int opened_folder(const std::string& folder) {
  const int descriptor = open(folder.c_str(), O_RDONLY | O_DIRECTORY);
  if (descriptor < 0) {
    throw InputError(folder, 0, "", std::string("cannot be opened: ") + std::strerror(errno));
  }
  return descriptor;
}

}  // namespace

int run_program(const std::vector<std::string>& command, const std::string& folder, const Streams& streams) {
  std::vector<std::string> words = command;
  const std::vector<char*> pointers = pointers_to(words);
  const std::string input = streams.in.empty() || streams.in[0] == '/' ? streams.in : folder + "/" + streams.in;
  const int in = opened(input, O_RDONLY, "read");
  const int out = opened(streams.out, O_WRONLY | O_CREAT | O_APPEND, "written");
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  if (in >= 0) {
    posix_spawn_file_actions_adddup2(&actions, in, STDIN_FILENO);
  }
  if (out >= 0) {
    posix_spawn_file_actions_adddup2(&actions, out, STDOUT_FILENO);
    sigset_t blocked;
    sigemptyset(&blocked);
    sigaddset(&blocked, SIGINT);
    posix_spawnattr_setsigmask(&attributes, &blocked);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
  }
  pid_t child = -1;
  const int wrong = posix_spawnp(&child, pointers[0], &actions, &attributes, pointers.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  posix_spawnattr_destroy(&attributes);
  for (const int descriptor : {in, out}) {
    if (descriptor >= 0) {
      close(descriptor);
    }
  }
  int status = 0;
  if (wrong == 0) {
    interruption().child = child;
  }
  const bool ended = wrong == 0 && waitpid(child, &status, 0) == child;
  interruption().child = 0;
  if (!ended && command.front() == "ssh") {
    throw InputError("ssh", 0, "--board", "cannot be started; install the package openssh-client");
  }
  if (!ended) {
    throw InputError(command.front(), 0, "", "cannot be started; use --m100 to name the program m100 on this machine");
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

SideProgram::SideProgram(std::vector<std::string> command, const std::string& folder, const std::string& said)
    : child_(fork()) {
  if (child_ == 0) {
    const int out = open((folder + "/" + said).c_str(), O_WRONLY | O_CREAT | O_APPEND, 0644);
    const bool moved = chdir(folder.c_str()) == 0 && dup2(out, STDOUT_FILENO) >= 0 && dup2(out, STDERR_FILENO) >= 0;
    close_range(STDERR_FILENO + 1, ~0U, 0);
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    const std::vector<char*> pointers = pointers_to(command);
    if (moved) {
      execv(pointers[0], pointers.data());
    }
    _exit(127);
  }
  usleep(200'000);
  if (child_ < 0 || waitpid(child_, nullptr, WNOHANG) == child_) {
    throw InputError(folder + "/" + said, 0, "", "`" + typed(command) + "` has ended; this file says why");
  }
}

SideProgram::~SideProgram() {
  kill(child_, SIGTERM);
  waitpid(child_, nullptr, 0);
}

bool FolderLock::is_held(const std::string& folder) {
  const int descriptor = opened_folder(folder);
  const bool held = flock(descriptor, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  close(descriptor);
  return held;
}

FolderLock::FolderLock(const std::string& folder) : descriptor_(opened_folder(folder)) {
  // Not closed on exec, so that started programs keep the lock.
  if (flock(descriptor_.number, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    throw InputError(
        folder, 0, "",
        "another evening works in this folder, or the last command of a killed evening does; run this again "
        "when it has ended");
  }
}

}  // namespace m100::lab::evening
