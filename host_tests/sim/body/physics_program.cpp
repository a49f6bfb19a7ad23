// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/body/physics_program.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <thread>

#include "host_tests/sim/body/sim_json.h"

namespace m100::sim {
namespace {

constexpr int kSignalled = 128;  // a shell's exit code for a program that ended by a signal, less its number

/// Ends the whole process group, this process included.
void end_group(int) { ::kill(0, SIGKILL); }

[[noreturn]] void run_shell(const char* command) {
  ::signal(SIGINT, SIG_DFL);
  ::signal(SIGTERM, SIG_DFL);
  ::signal(SIGPIPE, SIG_DFL);
  // Standard output is the results' of this program: a physics program that chats does so on standard error.
  ::dup2(STDERR_FILENO, STDOUT_FILENO);
  const int nothing = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
  ::dup2(nothing, STDIN_FILENO);
  ::execl("/bin/sh", "sh", "-c", command, static_cast<char*>(nullptr));
  ::_exit(127);
}

/// What the new process does: it leads a group in which the shell runs, and ends the group when its parent is gone,
/// also by SIGKILL. Only calls that are safe between fork and exec in a program with several threads.
[[noreturn]] void supervise(const char* command, pid_t parent) {
  ::setpgid(0, 0);
  ::signal(SIGINT, SIG_IGN);
  ::signal(SIGTERM, SIG_IGN);  // meant for the physics program, whose end ends this process
  ::signal(SIGUSR1, end_group);
  ::prctl(PR_SET_PDEATHSIG, SIGUSR1);
  if (::getppid() != parent) {
    ::_exit(127);  // the parent died before the line above
  }
  const pid_t shell = ::fork();
  if (shell == 0) {
    run_shell(command);
  }
  // A shell that is ended leaves its program to this process. Processor time counts once it has been waited for.
  ::prctl(PR_SET_CHILD_SUBREAPER, 1);
  int status = 0;
  while (shell > 0 && ::waitpid(shell, &status, 0) < 0 && errno == EINTR) {
  }
  for (int look = 0; look < 20 && ::waitpid(-1, nullptr, WNOHANG) >= 0; ++look) {
    ::usleep(10'000);
  }
  ::_exit(shell < 0 ? 127 : WIFEXITED(status) ? WEXITSTATUS(status) : kSignalled + WTERMSIG(status));
}

}  // namespace

PhysicsProgram::PhysicsProgram(const std::string& command) {
  const pid_t parent = ::getpid();
  process_ = ::fork();
  if (process_ == 0) {
    supervise(command.c_str(), parent);
  }
  if (process_ < 0) {
    throw PhysicsError("the physics program cannot be started: " + std::string(std::strerror(errno)));
  }
  ::setpgid(process_, process_);  // done on both sides, because either may be first
}

std::string PhysicsProgram::ending() {
  int status = 0;
  if (ending_.empty() && ::waitpid(process_, &status, WNOHANG) == process_) {
    const int code = WIFEXITED(status) ? WEXITSTATUS(status) : kSignalled + WTERMSIG(status);
    ending_ = code > kSignalled ? "signal " + std::to_string(code - kSignalled) : "exit code " + std::to_string(code);
  }
  return ending_;
}

PhysicsProgram::~PhysicsProgram() {
  constexpr int kLooks = 50;  // half a second to end by itself
  ::kill(-process_, SIGTERM);
  for (int look = 0; look < kLooks && ending().empty(); ++look) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  ::kill(-process_, SIGKILL);
  if (ending().empty()) {
    int status = 0;
    ::waitpid(process_, &status, 0);
  }
}

std::uint16_t free_port() {
  const int descriptor = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof(address);
  const bool bound = ::bind(descriptor, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0 &&
                     ::getsockname(descriptor, reinterpret_cast<sockaddr*>(&address), &size) == 0;
  ::close(descriptor);
  if (!bound) {
    throw PhysicsError("this machine has no free UDP port: " + std::string(std::strerror(errno)));
  }
  return ntohs(address.sin_port);
}

}  // namespace m100::sim
