// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string>

namespace m100::sim {

/// A physics program that we start and end: a shell command in a process group of its own.
///
/// The destructor ends the whole group. If this process dies without its destructors, the kernel ends the program.
class PhysicsProgram {
 public:
  /// @throws PhysicsError
  explicit PhysicsProgram(const std::string& command);
  ~PhysicsProgram();
  PhysicsProgram(const PhysicsProgram&) = delete;
  PhysicsProgram& operator=(const PhysicsProgram&) = delete;

  /// How it ended, such as "exit code 1" or "signal 9"; empty: it runs.
  std::string ending();
  pid_t process() const { return process_; }

 private:
  std::string ending_;
  pid_t process_ = -1;
};

/// A UDP port of this machine on which nothing listens at present.
std::uint16_t free_port();

}  // namespace m100::sim
