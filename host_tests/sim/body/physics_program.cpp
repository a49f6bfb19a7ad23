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

/// What the new process does. Only calls that are safe between fork and exec of a program with several threads.
[[noreturn]] void become(const char* command, pid_t parent) {
  ::setpgid(0, 0);
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) {
    ::_exit(127);  // the parent died before the line above
  }
  ::signal(SIGINT, SIG_DFL);
  ::signal(SIGTERM, SIG_DFL);
  // Standard output is the results' of this program: a physics program that chats does so on standard error.
  ::dup2(STDERR_FILENO, STDOUT_FILENO);
  const int nothing = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
  ::dup2(nothing, STDIN_FILENO);
  ::execl("/bin/sh", "sh", "-c", command, static_cast<char*>(nullptr));
  ::_exit(127);
}

}  // namespace

PhysicsProgram::PhysicsProgram(const std::string& command) {
  const pid_t parent = ::getpid();
  process_ = ::fork();
  if (process_ == 0) {
    become(command.c_str(), parent);
  }
  if (process_ < 0) {
    throw PhysicsError("the physics program cannot be started: " + std::string(std::strerror(errno)));
  }
  ::setpgid(process_, process_);  // done on both sides, because either may be first
}

std::string PhysicsProgram::ending() {
  int status = 0;
  if (ending_.empty() && ::waitpid(process_, &status, WNOHANG) == process_) {
    ending_ = WIFEXITED(status) ? "exit code " + std::to_string(WEXITSTATUS(status))
                                : "signal " + std::to_string(WTERMSIG(status));
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
