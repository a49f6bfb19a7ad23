// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

#include "hal/linux/descriptor.h"

namespace m100::lab::evening {

/// A command as typed into a shell: words that contain special characters are quoted.
std::string typed(const std::vector<std::string>& command);

/// Paths: `in` from the program's folder, `out` (appended to) from our working directory. Empty: our own stream.
struct Streams {
  std::string in = {};
  std::string out = {};
};

/// Runs a program inside the folder; it shares our standard error. If its output is a file, Ctrl-C reaches us only, and
/// we end it (interruption.h). @returns its exit code, or 128 plus the number of the signal that ended it. Errors:
/// InputError if a file cannot be opened or the program cannot be started.
int run_program(const std::vector<std::string>& command, const std::string& folder, const Streams& streams);

/// A program of ours that runs beside a step, inside the folder, and is ended with this object, or if our process ends.
/// It does not hold the folder's lock.
class SideProgram {
 public:
  /// @param said file of the folder to which its output is appended
  /// Errors: InputError if it cannot be started, or ends within a fifth of a second.
  SideProgram(std::vector<std::string> command, const std::string& folder, const std::string& said);
  ~SideProgram();
  SideProgram(const SideProgram&) = delete;
  SideProgram& operator=(const SideProgram&) = delete;

 private:
  pid_t child_;
};

/// A lock on a folder. Programs that run_program() starts hold it as long as they run, because the last command of a
/// killed evening may still be writing.
class FolderLock {
 public:
  /// Errors: InputError if another evening, or the last command of one, works there.
  explicit FolderLock(const std::string& folder);
  /// Whether an evening, or the last command of one, works there now. The folder must exist.
  static bool is_held(const std::string& folder);

 private:
  hal::Descriptor descriptor_;
};

}  // namespace m100::lab::evening
